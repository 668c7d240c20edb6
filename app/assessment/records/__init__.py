"""Patients' records as a whole: erased, ended again after a restore, put right."""
