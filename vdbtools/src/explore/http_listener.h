// SPDX-License-Identifier: Apache-2.0
/// @file http_listener.h
/// The port at which the server waits for connections.
#pragma once

#include <chrono>
#include <string>

namespace vdbtools::explore {

bool isIp4(const std::string& address);
bool isIp6(const std::string& address);

class HttpListener {
 public:
  /// @param address  an IP address of this machine
  /// @param port     0: any free port
  /// @throw CreateError  the port cannot be taken
  HttpListener(const std::string& address, int port);
  ~HttpListener();
  HttpListener(const HttpListener&) = delete;
  HttpListener& operator=(const HttpListener&) = delete;

  int port() const;

  /// The socket of the next connection; negative if none came in time.
  int accept(std::chrono::milliseconds wait);

 private:
  int mSocket;
};

}  // namespace vdbtools::explore
