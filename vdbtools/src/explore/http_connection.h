// SPDX-License-Identifier: Apache-2.0
/// @file http_connection.h
/// One connection to the server. Everything that a client sends has a limit of bytes and of time, so that a slow,
/// endless or broken one holds its connection for seconds only.
#pragma once

#include "explore/http_head.h"

#include <atomic>
#include <chrono>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace vdbtools::explore {

struct HttpAnswer {
  int status = 200;
  std::string_view fields;  ///< the header fields, each with its line end
  std::string_view type;    ///< the type of the body; empty: there is none
  std::string_view body;
  bool headOnly = false;  ///< the body is not sent, only its length
};

class HttpConnection {
 public:
  using Clock = std::chrono::steady_clock;

  /// @param socket   non-blocking; closed at the end
  /// @param stopped  ends all waiting once it is true; must outlive this
  HttpConnection(int socket, const std::atomic<bool>& stopped);
  ~HttpConnection();
  HttpConnection(const HttpConnection&) = delete;
  HttpConnection& operator=(const HttpConnection&) = delete;

  /// Waits for the head of the next request. Returns nothing if none came, or if it was malformed; in the second case,
  /// the client has been answered.
  std::optional<HttpHead> readHead();

  /// Reads the body of the current request. Returns nothing if it did not arrive in time.
  std::optional<std::string> readBody(std::size_t length);

  /// Call it before the answer, which then tells the client that no further request is read from this connection.
  void endAfterThis() { mEnds = true; }
  bool ends() const { return mEnds; }

  /// Whether the client has closed the connection. Any thread may call it.
  bool isDropped() const;

  void send(const HttpAnswer& answer);

  /// Sends a last answer, without a body, to a client whose request was not read. It needs no memory.
  /// @param atOnce  whether the connection is closed without waiting for the client to see it
  void refuse(int status, bool atOnce = false);

 private:
  bool await(short events, Clock::time_point deadline) const;
  bool receive(Clock::time_point deadline);
  bool write(std::string_view bytes);
  void linger();

  int mSocket;
  const std::atomic<bool>& mStopped;
  std::string mReceived;  ///< bytes that were received but not used yet
  bool mEnds = false;
};

}  // namespace vdbtools::explore
