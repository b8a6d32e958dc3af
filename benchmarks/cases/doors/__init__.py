"""Models, tables and files that go out to other programs and come back, by the hundred."""
