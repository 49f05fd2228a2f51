"""What crosses between processes: addresses, messages, codec, link and scenario. Imports nothing of ours."""
