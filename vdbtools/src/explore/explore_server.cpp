// SPDX-License-Identifier: Apache-2.0
// Accepts connections, and decides which requests are served at all, before a body is read.
#include "vdbtools/explore/explore_server.h"

#include "explore/explore_session.h"
#include "explore/http_connection.h"
#include "explore/http_listener.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/base/text.h"
#include "vdbtools/explore/embedded_page.h"
#include "vdbtools/files/file_bytes.h"

#include <openssl/crypto.h>
#include <openssl/rand.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <stdexcept>
#include <thread>

#include <unistd.h>

namespace vdbtools::explore {
namespace {

using std::chrono::milliseconds;

constexpr int kMostConnections = 64;
constexpr int kMostRequests = 1000;  // on one connection

// Restricts the page in the browser to content from the same address.
constexpr std::string_view kSecurityFields =
    "Content-Security-Policy: default-src 'self'; img-src 'self' blob: data:; worker-src 'self' blob:; "
    "object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r\n"
    "X-Content-Type-Options: nosniff\r\n"
    "X-Frame-Options: DENY\r\n"
    "Referrer-Policy: no-referrer\r\n"
    "Cross-Origin-Opener-Policy: same-origin\r\n"
    "Cross-Origin-Resource-Policy: same-origin\r\n"
    "Cache-Control: no-store\r\n";

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

/// Compares in a time that does not depend on where the texts differ.
bool sameKey(std::string_view a, std::string_view b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

std::string machineName() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? std::string(name.data()) : std::string();
}

/// The form of an IP address in a URL.
std::string inAddress(const std::string& address) { return isIp6(address) ? '[' + address + ']' : address; }

/// Cancels the work for an answer once the client has closed the connection.
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

/// Runs one thread for each connection, up to a maximum number.
class ConnectionThreads {
 public:
  /// @return false if there are too many already
  bool start(const std::function<void()>& serve) {
    const std::lock_guard lock(mMutex);
    if (mActive == kMostConnections) return false;
    try {
      std::thread([this, serve] {
        serve();
        const std::lock_guard ended(mMutex);
        --mActive;
        mEnded.notify_all();
      }).detach();
    } catch (const std::exception&) {
      return false;  // the system has no more threads, or no more memory
    }
    ++mActive;
    return true;
  }

  /// Waits until all threads have ended.
  void wait() {
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

class ExploreServer::State {
 public:
  State(const ExploreOptions& options, Monitor& monitor)
      : mLoopback(isLoopback(options.address)),
        mAddress(options.address),
        mSession(options, monitor),
        mListener(options.address, options.port),
        mPort(mListener.port()) {
    findHosts();
  }

  std::string url() const {
    const bool any = mAddress == "0.0.0.0" || mAddress == "::";
    return "http://" + (any ? machineName() : inAddress(mAddress)) + ':' + std::to_string(mPort) + '/' + mKey + '/';
  }

  void serve(const Monitor& monitor) {
    constexpr milliseconds kPeriod(50);
    while (!monitor.cancelled()) {
      const int socket = mListener.accept(kPeriod);
      if (socket >= 0 && !mThreads.start([this, socket] { serveConnection(socket); }))
        HttpConnection(socket, mStopped)
            .refuse(503, /*atOnce=*/true);  // at once, because this thread accepts the other connections
    }
    mStopped = true;
    mSession.stop();
    mThreads.wait();
  }

 private:
  void serveConnection(int socket) {
    HttpConnection connection(socket, mStopped);
    try {
      for (int left = kMostRequests; left > 0 && !connection.ends(); --left) {
        const std::optional<HttpHead> head = connection.readHead();
        if (!head) return;
        if (left == 1 || !head->persists()) connection.endAfterThis();
        handle(*head, connection);
      }
    } catch (const std::exception&) {
      connection.refuse(500);  // out of memory; other connections continue
    }
  }

  /// Finds the allowed values of the header Host. A name that an attacker has pointed at this machine (DNS rebinding)
  /// is not among them.
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
    // Anybody can point a name at this machine, but an IP address in the header was typed by the user.
    const std::string port = ':' + std::to_string(mPort);
    if (!host.ends_with(port)) return false;
    const std::string address = host.substr(0, host.size() - port.size());
    return isIp4(address) ||
           (address.starts_with('[') && address.ends_with(']') && isIp6(address.substr(1, address.size() - 2)));
  }

  /// The status with which a request is refused before its body is read; 0: it is not refused.
  /// @param path    receives the part of the path after the key
  /// @param length  receives the length of the body
  int refusalOf(const HttpHead& head, std::string& path, std::size_t& length) const {
    const std::string host = lowerCase(head.value("host"));
    if (head.count("host") != 1 || !isKnownHost(host)) return 403;
    const std::size_t origins = head.count("origin");
    if (origins > 1 || (origins == 1 && lowerCase(head.value("origin")) != "http://" + host)) return 403;
    // "/key/path"
    path = head.path();
    const std::size_t slash = path.find('/', 1);
    if (slash == std::string::npos || !sameKey(std::string_view(path).substr(1, slash - 1), mKey)) return 404;
    path.erase(0, slash + 1);
    const bool post = head.method == "POST";
    if (!post && head.method != "GET" && head.method != "HEAD" && head.method != "DELETE") return 405;
    if (head.count("transfer-encoding") != 0) return 411;
    if (head.count("content-encoding") != 0) return 415;
    const std::size_t lengths = head.count("content-length");
    if (lengths == 0) return post ? 411 : 0;
    const std::optional<std::size_t> given = wholeFromText<std::size_t>(head.value("content-length"));
    if (lengths > 1 || !given) return 400;
    length = *given;
    if (!post) return length == 0 ? 0 : 400;
    if (length > ExploreSession::mostBytes(path)) return 413;
    // A form on another site can send neither of these types without the browser asking this server first.
    const char* const type = path == "recipe" ? "application/octet-stream" : "application/json";
    return lowerCase(head.value("content-type")).starts_with(type) ? 0 : 415;
  }

  void handle(const HttpHead& head, HttpConnection& connection) {
    HttpAnswer answer{.fields = kSecurityFields, .type = "application/json", .headOnly = head.method == "HEAD"};
    std::string path;
    std::size_t length = 0;
    if (const int status = refusalOf(head, path, length)) {
      answer.status = status;
      answer.body = "{\"error\":\"refused\"}";
      connection.endAfterThis();
      return connection.send(answer);
    }
    if (head.method == "GET" || head.method == "HEAD") {
      const PageFile* file = path.empty()                ? findPageFile("index.html")
                             : path.starts_with("page/") ? findPageFile(std::string_view(path).substr(5))
                                                         : nullptr;
      if (file) {
        answer.type = file->contentType;
        answer.body = file->bytes;
        return connection.send(answer);
      }
    }
    ExploreRequest asked{.method = answer.headOnly ? "GET" : head.method, .path = path, .name = head.parameter("name")};
    const std::optional<ExploreAnswer> made = answerTo(asked, length, connection);
    if (made) {
      answer.status = made->status;
      answer.type = made->type;
      answer.body = made->body;
    } else {
      answer.status = 408;
      answer.type = {};
      connection.endAfterThis();
    }
    connection.send(answer);
  }

  /// Returns nothing if the body does not arrive.
  std::optional<ExploreAnswer> answerTo(ExploreRequest& asked, std::size_t length, HttpConnection& connection) {
    // Large bodies are handled one after another, because together they would not fit into memory.
    std::unique_lock lock(mLargeBody, std::defer_lock);
    constexpr std::size_t kLarge = 1 << 20;
    if (length > kLarge) lock.lock();
    std::optional<std::string> body = connection.readBody(length);
    if (!body) return std::nullopt;
    asked.body = std::move(*body);
    Waiting waiting(connection, mStopped);
    return mSession.answer(asked, waiting);
  }

  bool mLoopback;
  std::string mAddress;
  const std::string mKey = randomKey();
  std::atomic<bool> mStopped{false};
  std::mutex mLargeBody;
  ExploreSession mSession;
  HttpListener mListener;
  int mPort;
  std::vector<std::string> mHosts;
  ConnectionThreads mThreads;
};

ExploreServer::ExploreServer(const ExploreOptions& options, Monitor& monitor)
    : mState(std::make_unique<State>(options, monitor)) {}
ExploreServer::~ExploreServer() = default;

std::string ExploreServer::url() const { return mState->url(); }
void ExploreServer::serve(const Monitor& monitor) { mState->serve(monitor); }

}  // namespace vdbtools::explore
