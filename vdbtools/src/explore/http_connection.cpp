// SPDX-License-Identifier: Apache-2.0
#include "explore/http_connection.h"

#include "vdbtools/files/file_bytes.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <utility>

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

namespace vdbtools::explore {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr std::size_t kMostHeadBytes = 16384;
constexpr seconds kIdle(5);         // between two requests of a connection
constexpr seconds kHeadTime(5);     // from the first byte of a head to its last
constexpr seconds kBodyTime(10);    // for a body, plus a second for each MiB of it
constexpr seconds kWriteTime(30);   // while the client accepts no byte
constexpr milliseconds kSlice(50);  // the maximum time for which waiting continues after the server is stopped
constexpr std::size_t kMiB = 1 << 20;

/// The words after the number of a status.
const char* reasonOf(int status) {
  switch (status) {
    case 200: return "OK";
    case 400: return "Bad Request";
    case 403: return "Forbidden";
    case 404: return "Not Found";
    case 405: return "Method Not Allowed";
    case 408: return "Request Timeout";
    case 409: return "Conflict";
    case 411: return "Length Required";
    case 413: return "Content Too Large";
    case 415: return "Unsupported Media Type";
    case 422: return "Unprocessable Content";
    case 431: return "Request Header Fields Too Large";
    case 500: return "Internal Server Error";
    case 503: return "Service Unavailable";
    default: return "";
  }
}

}  // namespace

HttpConnection::HttpConnection(int socket, const std::atomic<bool>& stopped) : mSocket(socket), mStopped(stopped) {
  const int on = 1;
  ::setsockopt(mSocket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
}

HttpConnection::~HttpConnection() {
  if (mEnds) linger();
  ::close(mSocket);
}

bool HttpConnection::await(short events, Clock::time_point deadline) const {
  while (!mStopped) {
    const auto left = std::chrono::ceil<milliseconds>(deadline - Clock::now());
    if (left.count() <= 0) return false;
    pollfd entry{mSocket, events, 0};
    const int ready = ::poll(&entry, 1, static_cast<int>(std::min<milliseconds>(left, kSlice).count()));
    if (ready > 0) return true;
    if (ready < 0 && errno != EINTR) return false;
  }
  return false;
}

bool HttpConnection::receive(Clock::time_point deadline) {
  std::array<char, 65536> buffer;
  while (await(POLLIN, deadline)) {
    const ssize_t count = ::recv(mSocket, buffer.data(), buffer.size(), 0);
    if (count > 0) {
      mReceived.append(buffer.data(), static_cast<std::size_t>(count));
      return true;
    }
    if (count == 0 || (errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR)) return false;
  }
  return false;
}

std::optional<HttpHead> HttpConnection::readHead() {
  if (mReceived.empty() && !receive(Clock::now() + kIdle)) return std::nullopt;
  const auto deadline = Clock::now() + kHeadTime;
  std::size_t end;
  while ((end = mReceived.find("\r\n\r\n")) == std::string::npos) {
    if (mReceived.size() > kMostHeadBytes) break;
    if (!receive(deadline)) return std::nullopt;
  }
  if (end > kMostHeadBytes) {  // also true if it was not found: npos is larger
    refuse(431);
    return std::nullopt;
  }
  std::optional<HttpHead> head = parsedHead(std::string_view(mReceived).substr(0, end + 4));
  mReceived.erase(0, end + 4);
  if (!head) refuse(400);
  return head;
}

std::optional<std::string> HttpConnection::readBody(std::size_t length) {
  const auto deadline = Clock::now() + kBodyTime + seconds(length / kMiB);
  while (mReceived.size() < length)
    if (!receive(deadline)) return std::nullopt;
  std::string rest = mReceived.substr(length);
  mReceived.resize(length);
  return std::exchange(mReceived, std::move(rest));
}

bool HttpConnection::isDropped() const {
  pollfd entry{mSocket, POLLRDHUP, 0};
  return ::poll(&entry, 1, 0) > 0 && (entry.revents & (POLLRDHUP | POLLHUP | POLLERR | POLLNVAL)) != 0;
}

void HttpConnection::send(const HttpAnswer& answer) {
  std::string head = "HTTP/1.1 " + std::to_string(answer.status) + ' ' + reasonOf(answer.status) + "\r\n";
  head.append(answer.fields);
  if (!answer.type.empty()) head.append("Content-Type: ").append(answer.type).append("\r\n");
  head += "Content-Length: " + std::to_string(answer.body.size()) + "\r\n";
  if (mEnds) head += "Connection: close\r\n";
  head += "\r\n";
  if (!write(head) || (!answer.headOnly && !write(answer.body))) mEnds = true;
}

void HttpConnection::refuse(int status, bool atOnce) {
  std::array<char, 128> answer;
  const int size =
      std::snprintf(answer.data(), answer.size(), "HTTP/1.1 %d %s\r\nContent-Length: 0\r\nConnection: close\r\n\r\n",
                    status, reasonOf(status));
  // It fits into the socket's buffer, or is not worth waiting for.
  [[maybe_unused]] const ssize_t sent =
      ::send(mSocket, answer.data(), static_cast<std::size_t>(size), MSG_NOSIGNAL | MSG_DONTWAIT);
  mEnds = !atOnce;
}

bool HttpConnection::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::send(mSocket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (count > 0)
      bytes.remove_prefix(static_cast<std::size_t>(count));
    else if (count < 0 && errno == EINTR)
      continue;
    else if ((count < 0 && errno != EAGAIN && errno != EWOULDBLOCK) || !await(POLLOUT, Clock::now() + kWriteTime))
      return false;
  }
  return true;
}

void HttpConnection::linger() {
  // Closing a socket that has unread bytes resets the connection, and then the client may never see the answer.
  ::shutdown(mSocket, SHUT_WR);
  constexpr milliseconds kLinger(300);
  constexpr std::size_t kMost = 4 * kMiB;
  const auto deadline = Clock::now() + kLinger;
  std::array<char, 65536> unread;
  for (std::size_t size = 0; size < kMost && await(POLLIN, deadline);) {
    const ssize_t count = ::recv(mSocket, unread.data(), unread.size(), 0);
    if (count <= 0) return;
    size += static_cast<std::size_t>(count);
  }
}

}  // namespace vdbtools::explore
