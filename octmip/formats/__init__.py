"""Formats: tables, problems and trees as files, and values of files checked before they are used."""
