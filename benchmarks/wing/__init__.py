"""The wing beside other codes and other loads."""
