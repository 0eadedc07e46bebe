// SPDX-License-Identifier: Apache-2.0
// A client made of plain sockets, for tests only.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace knuckle::testing {

/// An answer to a request.
struct HttpAnswer {
  int status = 0;                             ///< 0: the connection ended before there was an answer
  std::map<std::string, std::string> fields;  ///< names in lower case
  std::string body;
};

/// A message of a WebSocket.
struct SocketMessage {
  int kind = -1;  ///< 1: text, 2: binary, 8: farewell; -1: the connection ended
  std::string bytes;
};

/// One connection to a port of this machine. What does not come within ten seconds counts as an end.
class PlainClient {
 public:
  /// `receive_bytes`: of the system's buffer; 0: its own choice.
  explicit PlainClient(int port, int receive_bytes = 0);
  ~PlainClient();
  PlainClient(PlainClient&& other) noexcept;
  PlainClient& operator=(PlainClient&&) = delete;

  /// False where the other side has ended the connection.
  bool send(std::string_view bytes) const;
  /// Says that nothing more comes.
  void end_sending() const;
  /// An answer with its body; of one to HEAD without.
  HttpAnswer answer(bool has_body = true);
  /// A line without its end; empty at the end of the connection.
  std::string line();
  /// As many bytes, or fewer at the end of the connection.
  std::string bytes(std::size_t count);
  /// Whether the other side ends the connection, after whatever it still sends.
  bool ends();

  /// Asks for a WebSocket; the answer has status 101 where there is one.
  HttpAnswer open_socket(std::string_view target, std::string_view more_fields = "");
  SocketMessage message();

 private:
  bool fill();

  int descriptor_ = -1;
  std::string waiting_;
};

/// A request: "GET /api/info", with the fields `Host: localhost` and more, each with its end of line.
std::string request(std::string_view method_and_target, std::string_view more_fields = "",
                    std::string_view body = "");

/// A frame of a WebSocket as clients send them: masked, unless `mask` is false.
std::string client_frame(int first_byte, std::string_view payload, bool mask = true);

/// Descriptors that this process has open.
int open_descriptors();

}  // namespace knuckle::testing
