"""The kinds of session, a folder each with a `KIND` in its module `kind`; see `app.recordings.analysis.kinds`."""
