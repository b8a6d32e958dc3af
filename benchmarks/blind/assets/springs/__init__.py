"""A family of assets in CalculiX with another idealisation: solid skins, web and ribs, every joint of springs."""
