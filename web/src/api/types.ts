// Short names for the generated wire types; the only file that knows how they are generated.
import type { components } from './schema';

type Schemas = components['schemas'];
/** A type of one kind of session, by the name that the service gives it. */
export type Named<Name extends keyof Schemas> = Schemas[Name];

export type Me = Schemas['Me'];
export type Role = Me['role'];
export type SignInRequest = Schemas['SignInRequest'];
export type Account = Schemas['AccountOut'];
export type AccountIn = Schemas['AccountIn'];
export type ClinicPatch = Schemas['ClinicPatch'];
export type AccountPatch = Schemas['AccountPatch'];
export type PasswordIn = Schemas['PasswordIn'];
export type Grant = Schemas['GrantOut'];
export type GrantIn = Schemas['GrantIn'];
export type DeviceToken = Schemas['DeviceTokenOut'];
export type PairingCode = Schemas['PairingCodeOut'];
export type DeviceTokenIn = Schemas['DeviceTokenIn'];
export type ConsentIn = Schemas['ConsentIn'];
export type AuditEntry = Schemas['AuditOut'];

export type Course = Schemas['CourseOut'];
export type CourseNoteIn = Schemas['CourseNoteIn'];
export type CaseloadRow = Schemas['CaseloadRow'];
export type Patient = Schemas['PatientOut'];
export type PatientIn = Schemas['NewPatientIn'];
export type PatientPatch = Schemas['PatientPatch'];
export type BodyDimensions = Schemas['BodyDimensionsIn'];
export type Progress = Schemas['Progress'];
export type ProgressMeasure = Schemas['ProgressMeasure'];
export type ProgressEvent = Schemas['ProgressEvent'];
export type Side = NonNullable<CaseloadRow['affected_side']>;

export type Exercise = Schemas['ExerciseOut'];
export type ExerciseIn = Schemas['ExerciseIn'];
export type ExerciseChange = Schemas['ExerciseChange'];
export type Posture = NonNullable<Exercise['posture']>;
export type Template = Schemas['TemplateOut'];
export type TemplateVersion = Schemas['TemplateVersionOut'];
export type TemplateVersionDetail = Schemas['TemplateVersionDetail'];
export type TemplateContent = Schemas['TemplateContent'];
export type TemplatePreviewIn = Schemas['TemplatePreviewIn'];
export type PhaseDesign = Schemas['PhaseDesign'];
export type TemplateDesign = Schemas['TemplateDesign'];
export type TemplateChange = Schemas['TemplateChange'];
export type TemplateCopyIn = Schemas['TemplateCopyIn'];
export type TemplateVersionIn = Schemas['TemplateVersionIn'];
export type CueDesign = Schemas['CueDesign'];
export type StopDesign = Schemas['StopDesign'];
export type KnotDesign = Schemas['KnotDesign'];
export type WeightDesign = Schemas['WeightDesign'];
export type TemplateMeasure = Schemas['TemplateMeasure'];
export type WeightedSum = Schemas['WeightedSum'];
export type TemplateIn = Schemas['TemplateIn'];
export type Repetition = Schemas['RepetitionOut'];
export type PhaseCurve = Schemas['PhaseCurve'];
export type Prescription = Schemas['PrescriptionOut'];
export type PrescriptionIn = Schemas['PrescriptionIn'];
export type PrescriptionChangeIn = Schemas['PrescriptionChangeIn'];

export type Session = Schemas['SessionOut'];
export type SessionDetail = Schemas['SessionDetail'];
export type SessionIn = Schemas['SessionIn'];
export type SessionState = Session['state'];
export type SessionEvent = Schemas['SessionEventOut'];
export type Placement = NonNullable<Schemas['CsvColumn']['placement']>;
export type Result = Schemas['ResultOut'];
export type Calibration = Schemas['CalibrationOut'];
export type Estimator = Schemas['EstimatorOut'];
export type Format = Schemas['FormatOut'];
export type ReprocessIn = Schemas['ReprocessIn'];
export type SessionPatch = Schemas['SessionPatch'];
export type MergeIn = Schemas['MergeIn'];
export type Job = Schemas['JobOut'];
export type UploadIn = Schemas['UploadIn'];
export type TablePreview = Schemas['TablePreview'];
export type SensorPreview = Schemas['SensorPreview'];
export type PreviewIn = Schemas['PreviewIn'];
export type CsvMapping = Schemas['CsvMapping'];
export type GuessedMapping = Schemas['GuessedMapping'];
export type GuessedColumn = Schemas['GuessedColumn'];
export type ViewIn = Schemas['ViewIn'];

export type AccuracyReport = Schemas['AccuracyReport'];
export type AccuracyProtocol = Schemas['AccuracyProtocol'];
export type AccuracyFigure = Schemas['AccuracyFigure'];
export type AccuracyPlot = Schemas['AccuracyPlot'];

export type Comparison = Schemas['ComparisonOut'];
export type ComparisonDetail = Schemas['ComparisonDetail'];
export type MeasureValue = Schemas['MeasureValue'];

export type LayoutMessage = Schemas['LayoutMessage'];
export type StateMessage = Schemas['StateMessage'];
export type HealthMessage = Schemas['HealthMessage'];
export type SensorHealth = Schemas['SensorHealth'];
export type EventMessage = Schemas['EventMessage'];
export type ErrorMessage = Schemas['ErrorMessage'];
export type CalibrationMessage = Schemas['CalibrationMessage'];
export type Worry = Schemas['WorryOut'];
export type Answers = Schemas['AnswersOut'];
export type AnswersIn = Schemas['AnswersIn'];
export type GuidanceMessage = Schemas['GuidanceMessage'];
export type CalibrationGuide = Schemas['CalibrationGuide'];
export type CalibrationStep = Schemas['CalibrationStep'];
export type CalibrationIn = Schemas['CalibrationIn'];
export type CalibrationKind = CalibrationIn['kind'];
export type SensorProgress = Schemas['SensorProgress'];
export type SensorFinding = Schemas['SensorFinding'];
export type Differences = Schemas['DifferencesOut'];
export type Pulse = Schemas['PulseMessage'];
export type LiveMessage =
  | LayoutMessage
  | StateMessage
  | HealthMessage
  | EventMessage
  | CalibrationMessage
  | GuidanceMessage
  | Pulse
  | ErrorMessage;
export type PlayerCommand = Schemas['PlayerCommand'];
export type CameraCommand = Schemas['CameraCommand'];
export type PlayerState = Schemas['PlayerState'];

export type MagneticSafety = Schemas['MagneticSafetyOut'];
export type MagneticSource = Schemas['MagneticSourceOut'];
export type MagneticSourceIn = Schemas['MagneticSourceIn'];
export type SourceStops = Schemas['SourceStopsOut'];
export type SourceCalibrationIn = Schemas['SourceCalibrationIn'];
export type SourceUse = Schemas['SourceUseOut'];
export type Series = Schemas['SeriesOut'];

export type Gait = Schemas['GaitOut'];
export type FootCurves = Schemas['FootCurvesOut'];
export type GaitFoot = Schemas['FootOut'];
export type Stride = Schemas['StrideOut'];
export type CycleCurve = Schemas['CycleCurve'];
export type WalkMeasure = Schemas['WalkMeasure'];
export type WalkRow = Schemas['WalkRow'];
export type Conditions = Schemas['ConditionsOut'];
export type MeasureChange = Schemas['MeasureChange'];
export type Markers = Schemas['MarkersOut'];
export type MarkerMotion = Schemas['MarkerMotionOut'];
export type MarkerReport = Schemas['MarkerReport'];
export type MarkerUploadIn = Schemas['MarkerUploadIn'];
