// SPDX-License-Identifier: Apache-2.0
// In place of explore_server.cpp where cpp-httplib is not installed.
#include "vdbtools/explore/explore_server.h"

#include <stdexcept>

namespace vdbtools::explore {

class ExploreServer::State {};

bool isLoopback(const std::string&) { return true; }

ExploreServer::ExploreServer(const ExploreOptions&, Monitor&) {
  throw std::invalid_argument(
      "this program was built without its server; install libcpp-httplib-dev and build it again, or use --export");
}
ExploreServer::~ExploreServer() = default;
std::string ExploreServer::url() const { return {}; }
void ExploreServer::serve(const Monitor&) {}

}  // namespace vdbtools::explore
