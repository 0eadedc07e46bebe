// SPDX-License-Identifier: Apache-2.0
// Where the tip of each index finger is [mm], while it moves, from a running `knuckle live --view`.
// usage: node index_tip.mjs [ADDRESS]        as the program prints it; http://127.0.0.1:8790/ without
import http from "node:http";
import { createInterface } from "node:readline";

const address = new URL(process.argv[2] ?? "http://127.0.0.1:8790/");
address.pathname = "/api/records.jsonl";
http.get(address, (records) => {
  createInterface({ input: records }).on("line", (line) => {
    const record = JSON.parse(line);
    for (const hand of record.hands) {
      const tip = hand.landmarks_mm.index_tip;
      if (tip) console.log(record.frame, hand.side, ...tip);
    }
  });
});
