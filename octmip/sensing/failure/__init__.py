"""Failure: trees and detectors for sensors that fail."""
