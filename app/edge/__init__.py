"""The outer skin of the HTTP service: error answers, headers, limits, logs, the static client and the API
page.

Only `app.main` uses this room.
"""
