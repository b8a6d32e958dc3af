"""The octmip command on files as they are found."""
