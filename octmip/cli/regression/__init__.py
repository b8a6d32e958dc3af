"""The commands where the column to predict holds numbers: solve --target, and certify, predict, report of its trees."""
