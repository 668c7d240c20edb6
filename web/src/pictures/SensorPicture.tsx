import './pictures.css';
import './SensorPicture.css';
// A sensor in the hand or on the table, with the axis that points up or down and how it is turned.
type Axis = 'x' | 'y' | 'z';

/** Width, depth and height of the box as it lies, by the axis that is upright. */
const LYING: Record<Axis, readonly [number, number, number]> = { z: [104, 66, 30], x: [66, 30, 104], y: [104, 30, 66] };

function Box({
  x,
  y,
  size: [width, depth, height],
  isOver,
}: {
  x: number;
  y: number;
  size: readonly [number, number, number];
  isOver?: boolean;
}) {
  const [dx, dy] = [depth * 0.55, depth * 0.4];
  return (
    <g className="sensor-box">
      <path d={`M${x} ${y}v${-height}h${width}v${height}z`} />
      <path
        className={isOver ? 'sensor-back' : 'sensor-top'}
        d={`M${x} ${y - height}l${dx} ${-dy}h${width}l${-dx} ${dy}z`}
      />
      <path className="sensor-side" d={`M${x + width} ${y}v${-height}l${dx} ${-dy}v${height}z`} />
    </g>
  );
}

function Frame({ children }: { children: React.ReactNode }) {
  return (
    <svg className="picture" viewBox="0 0 240 240" aria-hidden>
      {children}
    </svg>
  );
}

/** Laid down with an axis up or down; turned about it on the table, if asked for. */
export function LaidSensor({ axis, isDown, isTurned }: { axis: Axis; isDown?: boolean; isTurned?: boolean }) {
  const size = LYING[axis];
  const x = 112 - size[0] / 2 - size[1] * 0.27;
  const middle = x + size[0] / 2 + size[1] * 0.27;
  const top = 190 - size[2] - size[1] * 0.2;
  return (
    <Frame>
      <path className="figure-floor" d="M20 190h200" />
      <Box x={x} y={190} size={size} isOver={isDown} />
      <g className="figure-arrow">
        <path d={isDown ? `M${middle} ${top - 50}V${top - 14}` : `M${middle} ${top}V${top - 38}`} />
        <path
          className="figure-tip"
          d={isDown ? `M${middle} ${top - 2}l-8 -14h16z` : `M${middle} ${top - 52}l-8 14h16z`}
        />
        {isTurned && (
          <>
            <path d={`M${middle - 84} 196a84 20 0 0 0 166 6`} />
            <path className="figure-tip" d={`M${middle + 88} 190l-14 6l10 10z`} />
          </>
        )}
      </g>
      <text className="picture-letter" x={middle + 16} y={top - 28}>
        {axis}
      </text>
    </Frame>
  );
}

/** Several sensors on a table, left alone. */
export function RestingSensors() {
  return (
    <Frame>
      <path className="figure-floor" d="M10 176h220" />
      <Box x={22} y={170} size={[52, 34, 16]} />
      <Box x={92} y={170} size={[52, 34, 16]} />
      <Box x={162} y={170} size={[40, 34, 16]} />
      <path className="figure-chair" d="M34 176v44M206 176v44" />
    </Frame>
  );
}

/** Turned in all directions, as if painting the inside of a ball. */
export function TumbledSensor() {
  return (
    <Frame>
      <circle className="figure-ball" cx="120" cy="120" r="98" />
      <ellipse className="figure-ball" cx="120" cy="120" rx="98" ry="30" />
      <ellipse className="figure-ball" cx="120" cy="120" rx="30" ry="98" />
      <g transform="rotate(-24 120 120)">
        <Box x={78} y={140} size={[70, 46, 24]} />
      </g>
      <g className="figure-arrow">
        <path d="M40 60A100 100 0 0 1 176 38" />
        <path className="figure-tip" d="M188 46l-17 -1l8 -13z" />
        <path d="M200 180A100 100 0 0 1 64 202" />
        <path className="figure-tip" d="M52 194l17 1l-8 13z" />
      </g>
    </Frame>
  );
}
