// SPDX-License-Identifier: Apache-2.0
// The only source that sees cpp-httplib, besides http_connection.cpp. Of cpp-httplib it uses the loop that accepts
// connections, the parsing of heads and the writing of answers; which requests are served at all is decided here,
// before a body is read.
#include "vdbtools/explore/explore_server.h"

#include "explore/explore_session.h"
#include "explore/http_connection.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/base/number_text.h"
#include "vdbtools/explore/embedded_page.h"
#include "vdbtools/files/file_bytes.h"

#include <openssl/crypto.h>
#include <openssl/rand.h>

#include <array>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <new>
#include <stdexcept>
#include <thread>

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

namespace vdbtools::explore {
namespace {

using std::chrono::milliseconds;

constexpr int kMostConnections = 64;
constexpr int kMostRequests = 1000;  // on one connection
constexpr int kBacklog = 128;

// What a browser may do with the page: nothing but what comes from the same address.
constexpr std::pair<const char*, const char*> kSecurityHeaders[] = {
    {"Content-Security-Policy",
     "default-src 'self'; img-src 'self' blob: data:; worker-src 'self' blob:; object-src 'none'; base-uri 'none'; "
     "form-action 'none'; frame-ancestors 'none'"},
    {"X-Content-Type-Options", "nosniff"},
    {"X-Frame-Options", "DENY"},
    {"Referrer-Policy", "no-referrer"},
    {"Cross-Origin-Opener-Policy", "same-origin"},
    {"Cross-Origin-Resource-Policy", "same-origin"},
    {"Cache-Control", "no-store"}};

/// The connection whose request the thread is at.
thread_local HttpConnection* theConnection = nullptr;
/// Whether the thread is to refuse the connection that it is given.
thread_local bool theServerIsFull = false;

/// 128 random bits in hexadecimal.
std::string randomKey() {
  std::array<unsigned char, 16> bytes;
  if (RAND_bytes(bytes.data(), static_cast<int>(bytes.size())) != 1)
    throw std::runtime_error("there are no random numbers to be had for the key of the address");
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string key;
  for (const unsigned char byte : bytes) {
    key += kDigits[byte >> 4];
    key += kDigits[byte & 15];
  }
  return key;
}

/// In a time that does not depend on where they differ.
bool sameKey(std::string_view a, std::string_view b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

bool isIp4(const std::string& address) {
  in_addr ignored;
  return ::inet_pton(AF_INET, address.c_str(), &ignored) == 1;
}

bool isIp6(const std::string& address) {
  in6_addr ignored;
  return ::inet_pton(AF_INET6, address.c_str(), &ignored) == 1;
}

std::string machineName() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? std::string(name.data()) : std::string();
}

/// As it stands in an address.
std::string inAddress(const std::string& address) { return isIp6(address) ? '[' + address + ']' : address; }

/// Content-Length, if it is there and valid.
std::optional<std::size_t> bodyLength(const httplib::Request& request) {
  if (!request.has_header("Content-Length")) return std::nullopt;
  return wholeFromText<std::size_t>(request.get_header_value("Content-Length"));
}

/// Whoever waits for an answer: gone, once the connection is.
class Waiting final : public Monitor {
 public:
  Waiting(const HttpConnection& connection, const std::atomic<bool>& stopped)
      : mConnection(connection), mStopped(stopped) {}

  bool cancelled() const override {
    if (mStopped.load(std::memory_order_relaxed) || mGone.load(std::memory_order_relaxed)) return true;
    // Asking the socket costs a system call, and many threads ask for each small piece of work.
    constexpr std::int64_t kPeriod = 20'000'000;  // nanoseconds
    const std::int64_t now = std::chrono::nanoseconds(HttpConnection::Clock::now().time_since_epoch()).count();
    std::int64_t next = mNext.load(std::memory_order_relaxed);
    if (now < next || !mNext.compare_exchange_strong(next, now + kPeriod)) return false;
    if (mConnection.isDropped()) mGone = true;
    return mGone;
  }

 private:
  const HttpConnection& mConnection;
  const std::atomic<bool>& mStopped;
  mutable std::atomic<std::int64_t> mNext{0};
  mutable std::atomic<bool> mGone{false};
};

/// A thread for each connection, up to a number of them; the others are refused where they are accepted.
class ConnectionThreads final : public httplib::TaskQueue {
 public:
  void enqueue(std::function<void()> serve) override {
    {
      const std::lock_guard lock(mMutex);
      if (mActive < kMostConnections) {
        ++mActive;
        try {
          std::thread([this, serve] {
            serve();
            const std::lock_guard ended(mMutex);
            --mActive;
            mEnded.notify_all();
          }).detach();
          return;
        } catch (const std::system_error&) {
          --mActive;  // no more threads: full
        }
      }
    }
    theServerIsFull = true;
    serve();
    theServerIsFull = false;
  }

  void shutdown() override {
    std::unique_lock lock(mMutex);
    mEnded.wait(lock, [this] { return mActive == 0; });
  }

 private:
  std::mutex mMutex;
  std::condition_variable mEnded;
  int mActive = 0;
};

}  // namespace

bool isLoopback(const std::string& address) {
  if (isIp4(address)) return address.starts_with("127.");
  if (isIp6(address)) return address == "::1";
  throw std::invalid_argument("the address is '" + inOneLine(address) +
                              "'; it must be an IP address, such as 127.0.0.1");
}

class ExploreServer::State final : public httplib::Server {
 public:
  State(const ExploreOptions& options, Monitor& monitor)
      : mLoopback(isLoopback(options.address)), mAddress(options.address), mSession(options, monitor) {
    new_task_queue = [] { return new ConnectionThreads; };
    // A second server at the same port would take every other connection; the library's default allows it.
    set_socket_options([](socket_t socket) {
      const int on = 1;
      ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    });
    set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
      handle(request, response);
      return HandlerResponse::Handled;
    });
    mPort = options.port != 0 ? options.port : bind_to_any_port(mAddress);
    if (mPort <= 0 || (options.port != 0 && !bind_to_port(mAddress, mPort)))
      throw CreateError("cannot listen at port " + std::to_string(options.port) + " of " + mAddress +
                        ": another program may have it; choose another port");
    ::listen(svr_sock_, kBacklog);  // the library's own number is 5
    findHosts();
  }

  std::string url() const {
    const bool any = mAddress == "0.0.0.0" || mAddress == "::";
    return "http://" + (any ? machineName() : inAddress(mAddress)) + ':' + std::to_string(mPort) + '/' + mKey + '/';
  }

  void serve(const Monitor& monitor) {
    std::thread listener([this] { listen_after_bind(); });
    constexpr milliseconds kPeriod(50);
    while (!monitor.cancelled()) std::this_thread::sleep_for(kPeriod);
    mStopped = true;
    mSession.stop();
    httplib::Server::stop();
    listener.join();
  }

 private:
  bool process_and_close_socket(socket_t socket) override {
    HttpConnection connection(socket, mStopped);
    if (theServerIsFull) {
      connection.refuse("503 Service Unavailable", /*atOnce=*/true);  // this thread accepts the others
      return false;
    }
    theConnection = &connection;
    try {
      for (int left = kMostRequests; left > 0 && connection.readHead(); --left) {
        bool closed = false;
        if (!process_request(connection, left == 1, closed, nullptr) || closed || connection.ends()) break;
      }
    } catch (const std::exception&) {
      connection.refuse("500 Internal Server Error");  // out of memory; the others go on
    }
    theConnection = nullptr;
    return true;
  }

  /// What the header Host may be. An address that an attacker's own name leads to (DNS rebinding) is not among them.
  void findHosts() {
    const std::string port = ':' + std::to_string(mPort);
    mHosts = {"localhost" + port, inAddress(mAddress) + port};
    if (!mLoopback) mHosts.push_back(lowerCase(machineName()) + port);
    if (mPort != 80) return;
    for (std::size_t i = mHosts.size(); i-- > 0;) mHosts.push_back(mHosts[i].substr(0, mHosts[i].size() - port.size()));
  }

  bool isKnownHost(const std::string& host) const {
    if (std::find(mHosts.begin(), mHosts.end(), host) != mHosts.end()) return true;
    if (mLoopback) return false;
    // Names can be pointed here by anybody, but numbers only by the user.
    const std::string port = ':' + std::to_string(mPort);
    if (!host.ends_with(port)) return false;
    const std::string address = host.substr(0, host.size() - port.size());
    return isIp4(address) ||
           (address.starts_with('[') && address.ends_with(']') && isIp6(address.substr(1, address.size() - 2)));
  }

  /// The status of a refusal before anything of the body is read; 0: none.
  int refusalOf(const httplib::Request& request, std::string& path) const {
    if (request.get_header_value_count("Host") != 1 || !isKnownHost(lowerCase(request.get_header_value("Host"))))
      return 403;
    const std::size_t origins = request.get_header_value_count("Origin");
    if (origins > 1 || (origins == 1 && lowerCase(request.get_header_value("Origin")) !=
                                            "http://" + lowerCase(request.get_header_value("Host"))))
      return 403;
    // "/key/path"
    const std::size_t slash = request.path.find('/', 1);
    if (slash == std::string::npos || !sameKey(std::string_view(request.path).substr(1, slash - 1), mKey)) return 404;
    path = request.path.substr(slash + 1);
    const bool post = request.method == "POST";
    if (!post && request.method != "GET" && request.method != "HEAD" && request.method != "DELETE") return 405;
    if (request.has_header("Transfer-Encoding")) return 411;
    if (request.has_header("Content-Encoding")) return 415;
    if (request.get_header_value_count("Content-Length") > 1) return 400;
    const std::optional<std::size_t> length = bodyLength(request);
    if (request.has_header("Content-Length") && !length) return 400;
    if (!post) return length.value_or(0) == 0 ? 0 : 400;
    if (!length) return 411;
    if (*length > ExploreSession::mostBytes(path)) return 413;
    // A form of another site can send neither of these without asking.
    const char* const type = path == "recipe" ? "application/octet-stream" : "application/json";
    return lowerCase(request.get_header_value("Content-Type")).starts_with(type) ? 0 : 415;
  }

  void handle(const httplib::Request& request, httplib::Response& response) {
    HttpConnection& connection = *theConnection;
    for (const auto& [name, value] : kSecurityHeaders) response.set_header(name, value);
    std::string path;
    if (const int status = refusalOf(request, path)) {
      response.status = status;
      setBody(response, "{\"error\":\"refused\"}", "application/json");
      return end(connection, response);
    }
    if (request.method != "POST" && request.method != "DELETE") {
      const PageFile* file = path.empty()                ? findPageFile("index.html")
                             : path.starts_with("page/") ? findPageFile(std::string_view(path).substr(5))
                                                         : nullptr;
      if (file) {
        response.status = 200;
        return setBody(response, std::string(file->bytes), std::string(file->contentType));
      }
    }
    ExploreRequest asked{.method = request.method == "HEAD" ? "GET" : request.method, .path = path};
    if (request.has_param("name")) asked.name = request.get_param_value("name");
    if (request.method == "POST") {
      // Large bodies one after another: together they would not fit into the memory.
      const std::size_t length = bodyLength(request).value_or(0);
      std::unique_lock lock(mLargeBody, std::defer_lock);
      constexpr std::size_t kLarge = 1 << 20;
      if (length > kLarge) lock.lock();
      std::optional<std::string> body = connection.readBody(length);
      if (!body) {
        response.status = 408;
        return end(connection, response);
      }
      asked.body = std::move(*body);
      answer(asked, connection, response);
    } else {
      answer(asked, connection, response);
    }
  }

  void answer(const ExploreRequest& asked, HttpConnection& connection, httplib::Response& response) {
    Waiting waiting(connection, mStopped);
    ExploreAnswer answer = mSession.answer(asked, waiting);
    response.status = answer.status;
    setBody(response, std::move(answer.body), answer.type);
  }

  static void setBody(httplib::Response& response, std::string body, const std::string& type) {
    response.body = std::move(body);
    response.set_header("Content-Type", type);
  }

  static void end(HttpConnection& connection, httplib::Response& response) {
    response.set_header("Connection", "close");
    connection.endAfterThis();
  }

  bool mLoopback;
  std::string mAddress;
  int mPort = 0;
  const std::string mKey = randomKey();
  std::vector<std::string> mHosts;
  std::atomic<bool> mStopped{false};
  std::mutex mLargeBody;
  ExploreSession mSession;
};

ExploreServer::ExploreServer(const ExploreOptions& options, Monitor& monitor)
    : mState(std::make_unique<State>(options, monitor)) {}
ExploreServer::~ExploreServer() = default;

std::string ExploreServer::url() const { return mState->url(); }
void ExploreServer::serve(const Monitor& monitor) { mState->serve(monitor); }

}  // namespace vdbtools::explore
