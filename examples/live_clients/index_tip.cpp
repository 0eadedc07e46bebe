// SPDX-License-Identifier: Apache-2.0
// Where the tip of each index finger is [mm], while it moves, from a running `knuckle live --view`.
// usage: index_tip [ADDRESS]        as the program prints it; http://127.0.0.1:8790/ without
#include <cstdio>
#include <cstdlib>
#include <string>

#include <netdb.h>
#include <nlohmann/json.hpp>
#include <sys/socket.h>
#include <unistd.h>

int main(int count, char** arguments) {
  char host[256], port[6], query[64] = "";
  const char* const address = count > 1 ? arguments[1] : "http://127.0.0.1:8790/";
  addrinfo* place = nullptr;
  if (std::sscanf(address, "http://%255[^:/]:%5[0-9]/%63s", host, port, query) < 2) return EXIT_FAILURE;
  if (getaddrinfo(host, port, nullptr, &place) != 0) return EXIT_FAILURE;
  const int server = socket(place->ai_family, SOCK_STREAM, 0);
  if (connect(server, place->ai_addr, place->ai_addrlen) != 0) return EXIT_FAILURE;
  freeaddrinfo(place);
  // HTTP/1.0: the answer is a head, an empty line, and records without anything in between.
  dprintf(server, "GET /api/records.jsonl%s HTTP/1.0\r\nHost: %s:%s\r\n\r\n", query, host, port);
  std::FILE* const lines = fdopen(server, "r");
  char* line = nullptr;
  for (std::size_t room = 0; getline(&line, &room, lines) >= 0;) {
    if (line[0] != '{') continue;
    const auto record = nlohmann::json::parse(line);
    for (const auto& hand : record["hands"]) {
      const auto& tip = hand["landmarks_mm"]["index_tip"];
      if (tip.is_null()) continue;
      std::printf("%d %s %.3f %.3f %.3f\n", int(record["frame"]), std::string(hand["side"]).c_str(),
                  double(tip[0]), double(tip[1]), double(tip[2]));
      std::fflush(stdout);
    }
  }
  std::free(line);
  std::fclose(lines);
}
