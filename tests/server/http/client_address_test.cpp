// The address of a request's client: what proxies report, and which of them are trusted.
#include "server/http/client_address.hpp"

#include <gtest/gtest.h>

namespace fracture::http {
namespace {

TrustedProxies trusted(std::initializer_list<const char*> networks) {
  TrustedProxies proxies;
  for (const char* network : networks) EXPECT_TRUE(proxies.add(network)) << network;
  return proxies;
}

TEST(ClientAddress, AnIpv6ClientIsItsSlash64AndAMappedIpv4OneItself) {
  EXPECT_EQ(client_of("192.0.2.7"), "192.0.2.7");
  EXPECT_EQ(client_of("::ffff:192.0.2.7"), "192.0.2.7");
  EXPECT_EQ(client_of("2001:db8:1:2:3:4:5:6"), "2001:db8:1:2::/64");
  EXPECT_EQ(client_of("2001:db8:1:2:ffff::1"), client_of("2001:db8:1:2::"));
  EXPECT_NE(client_of("2001:db8:1:3::1"), client_of("2001:db8:1:2::1"));
  EXPECT_EQ(client_of("fe80::1%eth0"), "fe80::/64");
}

TEST(ClientAddress, NetworksAreReadStrictly) {
  TrustedProxies proxies;
  for (const char* wrong : {"", "192.0.2.1/24", "192.0.2.0/33", "192.0.2.0/", "192.0.2.0/-1", "192.0.2/24",
                            "2001:db8::1/64", "2001:db8::/129", "proxy", "192.0.2.0/24 "})
    EXPECT_FALSE(proxies.add(wrong)) << wrong;
  EXPECT_TRUE(proxies.empty());
  proxies = trusted({"192.0.2.128/25", "2001:db8::/33", "198.51.100.7"});
  EXPECT_TRUE(proxies.contains("192.0.2.200"));
  EXPECT_TRUE(proxies.contains("::ffff:192.0.2.200"));
  EXPECT_FALSE(proxies.contains("192.0.2.127"));
  EXPECT_TRUE(proxies.contains("2001:db8:7fff::1"));
  EXPECT_FALSE(proxies.contains("2001:db8:8000::1"));
  EXPECT_TRUE(proxies.contains("198.51.100.7"));
  EXPECT_FALSE(proxies.contains("198.51.100.8"));
  EXPECT_TRUE(trusted({"0.0.0.0/0"}).contains("8.8.8.8"));
  EXPECT_FALSE(trusted({"0.0.0.0/0"}).contains("2001:db8::1"));
}

TEST(ClientAddress, ForwardedIsBelievedOnlyOfTrustedProxiesAndOnlySoFar) {
  const TrustedProxies proxies = trusted({"192.0.2.0/24", "2001:db8::/32"});
  EXPECT_EQ(forwarded_client("203.0.113.1", "for=198.51.100.1", proxies), "203.0.113.1");
  EXPECT_EQ(forwarded_client("192.0.2.1", "", proxies), "192.0.2.1");
  EXPECT_EQ(forwarded_client("192.0.2.1", "for=198.51.100.1", proxies), "198.51.100.1");
  EXPECT_EQ(forwarded_client("192.0.2.1", "For=\"198.51.100.1:4711\";proto=https;by=10.0.0.1", proxies),
            "198.51.100.1");
  EXPECT_EQ(forwarded_client("192.0.2.1", "by=10.0.0.1; for=\"[2620:0:1::17]:4711\"", proxies),
            "2620:0:1::17");
  EXPECT_EQ(forwarded_client("192.0.2.1", "for=198.51.100.9, for=198.51.100.1", proxies), "198.51.100.1")
      << "what stands before it, the client wrote itself";
  EXPECT_EQ(forwarded_client("192.0.2.1", "for=198.51.100.1, for=192.0.2.2, for=\"[2001:db8::1]\"", proxies),
            "198.51.100.1")
      << "two proxies more";
  EXPECT_EQ(forwarded_client("192.0.2.1", "for=198.51.100.1, for=unknown", proxies), "192.0.2.1");
  EXPECT_EQ(forwarded_client("192.0.2.1", "for=\"_a, for=198.51.100.1\"", proxies), "192.0.2.1")
      << "one string";
  EXPECT_EQ(forwarded_client("192.0.2.1", "for=\"", proxies), "192.0.2.1");
  EXPECT_EQ(forwarded_client("192.0.2.1", "for=\"[\"", proxies), "192.0.2.1");
}

// RFC 7239, section 4: a proxy appends its element to the field that it received, even if that field is
// malformed.
TEST(ClientAddress, WhatAClientLeavesOpenSwallowsNothingOfItsProxys) {
  const TrustedProxies proxies = trusted({"192.0.2.0/24"});
  for (const char* own :
       {"for=6.6.6.6;x=\"", "\"", "for=\"6.6.6.6", "for=6.6.6.6;x=\"a\\", "for=6.6.6.6\\\"",
        "for=\"[::6]\";x=\"", ",\",\\\",", "for=6.6.6.6;x=\"a\\\"", "for=6.6.6.6;x=\";for=6.6.6.6"})
    for (const char* proxys :
         {"for=198.51.100.7", "for=\"198.51.100.7:80\"", "proto=https;for=198.51.100.7;host=\"a,b\"",
          "host=\"a\\\",b\\\\\";for=198.51.100.7", "for=198.51.100.7, for=192.0.2.9"})
      EXPECT_EQ(forwarded_client("192.0.2.1", std::string(own) + ", " + proxys, proxies), "198.51.100.7")
          << own << " | " << proxys;
  EXPECT_EQ(forwarded_client("192.0.2.1", "for=6.6.6.6;x=\"", proxies), "192.0.2.1")
      << "no proxy has written";
}

TEST(ClientAddress, ANodeIsAnAddressAndAPortAndNothingBehindThem) {
  const TrustedProxies proxies = trusted({"192.0.2.0/24"});
  for (const char* node : {"6.6.6.6", "\"6.6.6.6:80\"", "\"6.6.6.6:_x\"", "6.6.6.6:80"})
    EXPECT_EQ(forwarded_client("192.0.2.1", std::string("for=") + node, proxies), "6.6.6.6") << node;
  EXPECT_EQ(forwarded_client("192.0.2.1", "for=\"[2620::6]:_x\"", proxies), "2620::6");
  for (const char* node : {"\"[2620::6]x\"", "\"[2620::6]6.6.6.6\"", "\"6.6.6.6:x\"", "6.6.6.6:80:80",
                           "\"6.6.6.6:\"", "\"[6.6.6.6\"", "\"[2620::6]]\"", "6.6.6.6;for=6.6.6.7"})
    EXPECT_EQ(forwarded_client("192.0.2.1", std::string("for=") + node, proxies), "192.0.2.1") << node;
}

using State = ProxyHeader::State;

TEST(ClientAddress, VersionOneOfTheProxyProtocol) {
  const std::string four = "PROXY TCP4 192.0.2.1 192.0.2.2 1234 80\r\n";
  const ProxyHeader header = parse_proxy_header(four + "GET / HTTP/1.1\r\n");
  EXPECT_EQ(header.state, State::kThere);
  EXPECT_EQ(header.size, four.size());
  EXPECT_EQ(header.address, "192.0.2.1");
  EXPECT_EQ(parse_proxy_header("PROXY TCP6 2001:db8::1 2001:db8::2 1 2\r\n").address, "2001:db8::1");
  EXPECT_EQ(parse_proxy_header("PROXY UNKNOWN whatever\r\n").state, State::kThere);
  EXPECT_EQ(parse_proxy_header("PROXY UNKNOWN\r\n").address, "");
  for (std::size_t n = 0; n < four.size(); ++n)
    EXPECT_EQ(parse_proxy_header(four.substr(0, n)).state, State::kIncomplete) << n;
  for (const std::string wrong :
       {"PROXY \r\n", "PROXY TCP4\r\n", "PROXY TCP4 a b 1 2\r\n", "PROXY TCP4 192.0.2.1 192.0.2.2 1\r\n",
        "PROXY UDP4 192.0.2.1 192.0.2.2 1 2\r\n"})
    EXPECT_EQ(parse_proxy_header(wrong).state, State::kMalformed) << wrong;
  EXPECT_EQ(parse_proxy_header("PROXY " + std::string(101, 'x')).state, State::kMalformed) << "endless";
  for (const std::string http : {"GET / HTTP/1.1\r\n", "POST /", "PUT", "\r\nGET"})
    EXPECT_EQ(parse_proxy_header(http).state, State::kAbsent) << http;
}

TEST(ClientAddress, VersionTwoOfTheProxyProtocol) {
  const std::string signature("\r\n\r\n\0\r\nQUIT\n", 12);
  const auto header = [&](char command, char family, const std::string& rest) {
    return signature + command + family + std::string(1, static_cast<char>(rest.size() >> 8)) +
           static_cast<char>(rest.size() & 255) + rest;
  };
  const std::string four = header(0x21, 0x11, std::string("\xc0\0\2\1\xc0\0\2\2\1\2\0\x50", 12) + "tlv");
  const ProxyHeader there = parse_proxy_header(four + "GET");
  EXPECT_EQ(there.state, State::kThere);
  EXPECT_EQ(there.size, four.size());
  EXPECT_EQ(there.address, "192.0.2.1");
  const std::string six =
      header(0x21, 0x21, std::string("\x20\1\x0d\xb8\0\0\0\0\0\0\0\0\0\0\0\7", 16) + std::string(20, 'x'));
  EXPECT_EQ(parse_proxy_header(six).address, "2001:db8::7");
  EXPECT_EQ(parse_proxy_header(header(0x20, 0x00, "")).state, State::kThere) << "LOCAL: a health check";
  EXPECT_EQ(parse_proxy_header(header(0x20, 0x00, "")).address, "");
  for (std::size_t n = 0; n < four.size(); ++n)
    EXPECT_EQ(parse_proxy_header(four.substr(0, n)).state, State::kIncomplete) << n;
  EXPECT_EQ(parse_proxy_header(header(0x11, 0x11, std::string(12, 'x'))).state, State::kMalformed)
      << "version";
  EXPECT_EQ(parse_proxy_header(header(0x22, 0x11, std::string(12, 'x'))).state, State::kMalformed)
      << "command";
  EXPECT_EQ(parse_proxy_header(header(0x21, 0x11, std::string(11, 'x'))).state, State::kMalformed) << "short";
  EXPECT_EQ(parse_proxy_header(header(0x21, 0x21, std::string(35, 'x'))).state, State::kMalformed) << "short";
  EXPECT_EQ(parse_proxy_header(header(0x21, 0x11, std::string(5000, 'x'))).state, State::kMalformed)
      << "long";
}

}  // namespace
}  // namespace fracture::http
