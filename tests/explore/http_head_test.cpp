// SPDX-License-Identifier: Apache-2.0
#include "explore/http_head.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace {

using vdbtools::explore::HttpHead;
using vdbtools::explore::parsedHead;

const std::string kLine = "GET /key/start?name=a HTTP/1.1\r\n";

HttpHead headWith(const std::string& fields) {
  const std::optional<HttpHead> head = parsedHead(kLine + fields + "\r\n");
  EXPECT_TRUE(head) << fields;
  return head.value_or(HttpHead{});
}

HttpHead headOf(const std::string& target) {
  const std::optional<HttpHead> head = parsedHead("GET " + target + " HTTP/1.1\r\n\r\n");
  EXPECT_TRUE(head) << target;
  return head.value_or(HttpHead{});
}

TEST(HttpHead, SaysWhatTheClientSaid) {
  const HttpHead head = headWith("Host: a:1\r\nX-Empty:\r\nX-Wide: \t b  c \t\r\nhOST:b\r\n");
  EXPECT_EQ(head.method, "GET");
  EXPECT_EQ(head.target, "/key/start?name=a");
  EXPECT_EQ(head.path(), "/key/start");
  EXPECT_EQ(head.parameter("name"), "a");
  EXPECT_EQ(head.count("host"), 2u);
  EXPECT_EQ(head.value("host"), "a:1");
  EXPECT_EQ(head.count("x-empty"), 1u);
  EXPECT_EQ(head.value("x-empty"), "");
  EXPECT_EQ(head.value("x-wide"), "b  c");
  EXPECT_EQ(head.count("cookie"), 0u);
}

TEST(HttpHead, NoPartOfAGoodHeadIsOne) {
  const std::string good = kLine + "Host: localhost:80\r\nContent-Length: 12\r\n\r\n";
  ASSERT_TRUE(parsedHead(good));
  for (std::size_t size = 0; size < good.size(); ++size) EXPECT_FALSE(parsedHead(good.substr(0, size))) << size;
  EXPECT_FALSE(parsedHead(good + "\r\n"));
  EXPECT_FALSE(parsedHead("\r\n" + good));
}

TEST(HttpHead, RefusesWhatIsNotWellFormed) {
  for (const char* line : {"",
                           "GET",
                           "GET /",
                           "GET / ",
                           "GET  / HTTP/1.1",
                           "GET /  HTTP/1.1",
                           " GET / HTTP/1.1",
                           "GET / HTTP/1.1 ",
                           "GET / HTTP/1.2",
                           "GET / HTTP/2.0",
                           "GET / http/1.1",
                           "GET / HTTP/1.11",
                           "GET x HTTP/1.1",
                           "GET * HTTP/1.1",
                           "GET http://localhost/ HTTP/1.1",
                           "CONNECT localhost:80 HTTP/1.1",
                           "GET /a b HTTP/1.1",
                           "GET /a\tb HTTP/1.1",
                           "G(T / HTTP/1.1",
                           " / HTTP/1.1",
                           "GET\t/ HTTP/1.1",
                           "GET / HTTP/1.1\n"})
    EXPECT_FALSE(parsedHead(std::string(line) + "\r\n\r\n")) << line;
  for (const char* field : {"no colon", ": x", "a b: c", "Host : x", " folded: x", "\tfolded", "a: b\nc: d",
                            "a: b\rc: d", "a\x7f: b", "a: \x1b[0m", "\xc3\xa4: b"})
    EXPECT_FALSE(parsedHead(kLine + field + "\r\n\r\n")) << field;
  // Every control character but the tab, wherever it stands.
  for (int c = 0; c < 0x20; ++c) {
    if (c == '\t') continue;
    EXPECT_FALSE(parsedHead(kLine + "a: b" + static_cast<char>(c) + "c\r\n\r\n")) << c;
    std::string target = "GET /a?b HTTP/1.1\r\n\r\n";
    target[6] = static_cast<char>(c);
    EXPECT_FALSE(parsedHead(target)) << c;
  }
}

TEST(HttpHead, PathsAreDecodedOnce) {
  for (const auto& [target, path] : {std::pair<std::string, std::string>{"/", "/"},
                                     {"/a%20b%2Fc", "/a b/c"},
                                     {"/%252e", "/%2e"},
                                     {"/a+b", "/a+b"},
                                     {"/%", "/%"},
                                     {"/%4", "/%4"},
                                     {"/%zz%4g%-1%+1", "/%zz%4g%-1%+1"},
                                     {"/%41%4a%4A", "/AJJ"},
                                     {"/%c3%a4", "/\xc3\xa4"},
                                     {"/%00x", std::string("/\0x", 3)},
                                     {"/a%3Fb?c", "/a?b"}})
    EXPECT_EQ(headOf(target).path(), path) << target;
}

TEST(HttpHead, ParametersAreThoseOfTheQuery) {
  for (const auto& [target, name] : {std::pair<std::string, std::string>{"/?name=a.vdb", "a.vdb"},
                                     {"/?other=1&name=b&name=c", "b"},
                                     {"/?na%6De=a%26b%3Dc+d%2Be", "a&b=c d+e"},
                                     {"/?name=a=b", "a=b"},
                                     {"/?name", ""},
                                     {"/?names=a&xname=b", ""},
                                     {"/?&&=&name=x", "x"},
                                     {"/name=a", ""}})
    EXPECT_EQ(headOf(target).parameter("name"), name) << target;
}

TEST(HttpHead, ConnectionsPersistUnlessTheClientEndsThem) {
  EXPECT_TRUE(headWith("").persists());
  EXPECT_TRUE(headWith("Connection: keep-alive\r\n").persists());
  EXPECT_FALSE(headWith("Connection: close\r\n").persists());
  EXPECT_FALSE(headWith("Connection: TE, Close\r\n").persists());
  EXPECT_FALSE(headWith("Connection: keep-alive\r\nConnection: close\r\n").persists());
  EXPECT_FALSE(parsedHead("GET / HTTP/1.0\r\n\r\n")->persists());
}

}  // namespace
