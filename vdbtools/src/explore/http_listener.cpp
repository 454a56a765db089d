// SPDX-License-Identifier: Apache-2.0
#include "explore/http_listener.h"

#include "vdbtools/base/errors.h"

#include <cerrno>
#include <system_error>
#include <thread>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

namespace vdbtools::explore {
namespace {

constexpr int kBacklog = 128;

bool listenAt(int socket, const std::string& address, int port) {
  const int on = 1, off = 0;
  // The port of a server that has just ended can be taken over, but not that of a running one.
  ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  sockaddr_in four{};
  sockaddr_in6 six{};
  four.sin_family = AF_INET;
  six.sin6_family = AF_INET6;
  four.sin_port = six.sin6_port = htons(static_cast<std::uint16_t>(port));
  int bound;
  if (::inet_pton(AF_INET, address.c_str(), &four.sin_addr) == 1) {
    bound = ::bind(socket, reinterpret_cast<const sockaddr*>(&four), sizeof four);
  } else {
    ::inet_pton(AF_INET6, address.c_str(), &six.sin6_addr);
    ::setsockopt(socket, IPPROTO_IPV6, IPV6_V6ONLY, &off, sizeof off);  // "::" includes all IPv4 addresses
    bound = ::bind(socket, reinterpret_cast<const sockaddr*>(&six), sizeof six);
  }
  return bound == 0 && ::listen(socket, kBacklog) == 0;
}

}  // namespace

bool isIp4(const std::string& address) {
  in_addr ignored;
  return ::inet_pton(AF_INET, address.c_str(), &ignored) == 1;
}

bool isIp6(const std::string& address) {
  in6_addr ignored;
  return ::inet_pton(AF_INET6, address.c_str(), &ignored) == 1;
}

HttpListener::HttpListener(const std::string& address, int port)
    : mSocket(::socket(isIp4(address) ? AF_INET : AF_INET6, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {
  if (mSocket >= 0 && listenAt(mSocket, address, port)) return;
  const int error = errno;
  if (mSocket >= 0) ::close(mSocket);
  throw CreateError("cannot listen at port " + std::to_string(port) + " of " + address + ": " +
                    (error == EADDRINUSE
                         ? "another program may have it; choose another port"
                         : std::generic_category().message(error) + "; choose another port or address"));
}

HttpListener::~HttpListener() { ::close(mSocket); }

int HttpListener::port() const {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  ::getsockname(mSocket, reinterpret_cast<sockaddr*>(&address), &size);
  return ntohs(address.ss_family == AF_INET ? reinterpret_cast<const sockaddr_in&>(address).sin_port
                                            : reinterpret_cast<const sockaddr_in6&>(address).sin6_port);
}

int HttpListener::accept(std::chrono::milliseconds wait) {
  pollfd entry{mSocket, POLLIN, 0};
  if (::poll(&entry, 1, static_cast<int>(wait.count())) <= 0) return -1;
  const int socket = ::accept4(mSocket, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  // Usually the process has run out of descriptors, and the connection keeps waiting; trying again at once would only
  // waste time.
  if (socket < 0) std::this_thread::sleep_for(wait);
  return socket;
}

}  // namespace vdbtools::explore
