# SPDX-License-Identifier: Apache-2.0
"""Where the tip of each index finger is [mm], while it moves, from a running `knuckle live --view`.

usage: index_tip.py [ADDRESS]        as the program prints it; http://127.0.0.1:8790/ without
"""
import json
import sys
import urllib.parse
import urllib.request

address = sys.argv[1] if len(sys.argv) > 1 else "http://127.0.0.1:8790/"
records = urllib.parse.urlsplit(address)._replace(path="/api/records.jsonl").geturl()
for line in urllib.request.urlopen(records):
    record = json.loads(line)
    for hand in record["hands"]:
        if tip := hand["landmarks_mm"]["index_tip"]:
            print(record["frame"], hand["side"], *tip, flush=True)
