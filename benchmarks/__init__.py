"""Cases and studies that need octmip and femlib together; results go to `results/`."""
