"""The Telemotion service: accounts, patients, ingest, live sessions, store, comparison and views."""
