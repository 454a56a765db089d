// SPDX-License-Identifier: Apache-2.0
#include "explore/http_connection.h"

#include "vdbtools/files/file_bytes.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

#include <fcntl.h>
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
constexpr seconds kBodyTime(10);    // for a body, and a second more for every MiB of it
constexpr seconds kWriteTime(30);   // without a byte that the client takes
constexpr milliseconds kSlice(50);  // how soon waiting ends once the server is stopped
constexpr std::size_t kMiB = 1 << 20;

constexpr std::string_view kUsedHeaders[] = {"host",         "origin",           "connection",       "content-length",
                                             "content-type", "content-encoding", "transfer-encoding"};

bool isControl(char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }

/// A character of a header's name, RFC 9110 5.6.2.
bool isToken(char c) {
  constexpr std::string_view kOthers = "!#$%&'*+-.^_`|~";
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || kOthers.find(c) != kOthers.npos;
}

}  // namespace

std::optional<std::string> acceptedHead(std::string_view head) {
  std::string accepted;
  bool first = true;
  while (!head.empty()) {
    const std::size_t end = head.find("\r\n");
    if (end == head.npos) return std::nullopt;
    const std::string_view line = head.substr(0, end);
    head.remove_prefix(end + 2);
    if (line.empty()) break;
    if (std::any_of(line.begin(), line.end(), [](char c) { return isControl(c) && c != '\t'; })) return std::nullopt;
    if (first) {
      accepted.append(line).append("\r\n");
      first = false;
      continue;
    }
    const std::size_t colon = line.find(':');
    if (colon == 0 || colon == line.npos) return std::nullopt;
    const std::string_view name = line.substr(0, colon);
    if (!std::all_of(name.begin(), name.end(), isToken)) return std::nullopt;
    if (std::find(std::begin(kUsedHeaders), std::end(kUsedHeaders), lowerCase(name)) != std::end(kUsedHeaders))
      accepted.append(line).append("\r\n");
  }
  if (first) return std::nullopt;
  return accepted + "\r\n";
}

HttpConnection::HttpConnection(int socket, const std::atomic<bool>& stopped) : mSocket(socket), mStopped(stopped) {
  ::fcntl(mSocket, F_SETFL, ::fcntl(mSocket, F_GETFL) | O_NONBLOCK);
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

bool HttpConnection::readHead() {
  if (mReceived.empty() && !receive(Clock::now() + kIdle)) return false;
  const auto deadline = Clock::now() + kHeadTime;
  std::size_t end;
  while ((end = mReceived.find("\r\n\r\n")) == std::string::npos) {
    if (mReceived.size() > kMostHeadBytes) break;
    if (!receive(deadline)) return false;
  }
  if (end > kMostHeadBytes) {  // or nowhere: npos is more than that
    refuse("431 Request Header Fields Too Large");
    return false;
  }
  std::optional<std::string> head = acceptedHead(std::string_view(mReceived).substr(0, end + 4));
  mReceived.erase(0, end + 4);
  if (!head) {
    refuse("400 Bad Request");
    return false;
  }
  mHead = std::move(*head);
  mNext = 0;
  return true;
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

void HttpConnection::refuse(std::string_view status, bool atOnce) {
  const std::string answer = "HTTP/1.1 " + std::string(status) + "\r\nContent-Length: 0\r\nConnection: close\r\n\r\n";
  // It fits into the socket's buffer, or is not worth waiting for.
  [[maybe_unused]] const ssize_t sent = ::send(mSocket, answer.data(), answer.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  mEnds = !atOnce;
}

void HttpConnection::linger() {
  // A socket that is closed with bytes unread resets the connection, and the client may never see the answer.
  ::shutdown(mSocket, SHUT_WR);
  constexpr milliseconds kLinger(300);
  constexpr std::size_t kMost = 4 * kMiB;
  const auto deadline = Clock::now() + kLinger;
  for (std::size_t read = 0; read < kMost; read += mReceived.size()) {
    mReceived.clear();
    if (!receive(deadline)) return;
  }
}

ssize_t HttpConnection::read(char* bytes, size_t size) {
  const std::size_t count = mHead.copy(bytes, size, mNext);
  mNext += count;
  return static_cast<ssize_t>(count);
}

ssize_t HttpConnection::write(const char* bytes, size_t size) {
  std::size_t done = 0;
  while (done < size) {
    const ssize_t count = ::send(mSocket, bytes + done, size - done, MSG_NOSIGNAL);
    if (count > 0) {
      done += static_cast<std::size_t>(count);
      continue;
    }
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && errno != EAGAIN && errno != EWOULDBLOCK) return -1;
    if (!await(POLLOUT, Clock::now() + kWriteTime)) return -1;
  }
  return static_cast<ssize_t>(size);
}

void HttpConnection::get_remote_ip_and_port(std::string& address, int& port) const {
  address.clear();
  port = 0;
}

void HttpConnection::get_local_ip_and_port(std::string& address, int& port) const {
  address.clear();
  port = 0;
}

}  // namespace vdbtools::explore
