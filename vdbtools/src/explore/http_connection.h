// SPDX-License-Identifier: Apache-2.0
/// @file http_connection.h
/// One connection to the server, behind cpp-httplib's interface of a stream. Everything that a client sends has a limit
/// of bytes and of time, so that a slow, endless or broken one holds its connection for seconds only.
///
/// The head of a request is read and checked before cpp-httplib sees it, and only the headers that the server uses are
/// passed on: whatever cpp-httplib would do about ranges, compression, forms and cookies cannot be asked for.
#pragma once

#include <httplib.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace vdbtools::explore {

/// The head of a request with only the headers that the server uses: everything up to and including the empty line.
/// Nothing if it is not well formed: a line without a colon, a continued line, a control character.
std::optional<std::string> acceptedHead(std::string_view head);

class HttpConnection final : public httplib::Stream {
 public:
  using Clock = std::chrono::steady_clock;

  /// @param socket   is closed at the end
  /// @param stopped  once it is true, waiting ends; outlives this
  HttpConnection(int socket, const std::atomic<bool>& stopped);
  ~HttpConnection() override;
  HttpConnection(const HttpConnection&) = delete;
  HttpConnection& operator=(const HttpConnection&) = delete;

  /// Waits for the head of the next request, which read() then gives. False: none came, or not a good one, and the
  /// client has been told so.
  bool readHead();

  /// The body of the request at hand. Nothing if it did not come in time.
  std::optional<std::string> readBody(std::size_t length);

  /// No further request is read from this connection: its body was refused, or does not come.
  void endAfterThis() { mEnds = true; }
  bool ends() const { return mEnds; }

  /// Whether the client has gone. From any thread.
  bool isDropped() const;

  /// A last answer without a body, to a client whose request was not read.
  /// @param atOnce  whether the connection is closed without waiting for the client to see it
  void refuse(std::string_view status, bool atOnce = false);

  // Of httplib::Stream.
  bool is_readable() const override { return mNext < mHead.size(); }
  bool is_writable() const override { return !isDropped(); }
  ssize_t read(char* bytes, size_t size) override;
  ssize_t write(const char* bytes, size_t size) override;
  void get_remote_ip_and_port(std::string& address, int& port) const override;
  void get_local_ip_and_port(std::string& address, int& port) const override;
  socket_t socket() const override { return mSocket; }

 private:
  bool await(short events, Clock::time_point deadline) const;
  bool receive(Clock::time_point deadline);
  void linger();

  int mSocket;
  const std::atomic<bool>& mStopped;
  std::string mReceived;  ///< and not used yet
  std::string mHead;      ///< for cpp-httplib
  std::size_t mNext = 0;  ///< of mHead
  bool mEnds = false;
};

}  // namespace vdbtools::explore
