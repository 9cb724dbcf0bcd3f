#include "tests/server/support/proxies.hpp"

#include <sstream>
#include <stdexcept>
#include <utility>

#include "tests/server/support/raw_client.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {

Proxy::Proxy(Kind kind, const std::vector<Server>& servers) : port(free_port()) {
  const std::string listen = "127.0.0.1:" + std::to_string(port), program = *find_program(name(kind));
  std::vector<std::string> arguments;
  if (kind == Kind::kHaproxy) {
    log_ = folder_ / "output";
    std::string list;
    for (const Server& server : servers) {
      list += "  server s" + std::to_string(server.port) + " 127.0.0.1:" + std::to_string(server.port);
      if (server.admin_port != 0)
        list += " check port " + std::to_string(server.admin_port) + " inter 100ms fall 1 rise 1";
      list += "\n";
    }
    arguments = {program, "-db", "-f",
                 folder_.write("haproxy.cfg",
                               "global\n  maxconn 200\n  log stdout format raw local0\n"
                               "defaults\n  mode http\n  log global\n"
                               // The time to connect, -1 if nothing was sent on.
                               "  log-format \"request %Tc %ST\"\n"
                               "  timeout connect 2s\n  timeout client 3s\n  timeout server 20s\n"
                               "  timeout http-request 2s\n  timeout http-keep-alive 3s\n"
                               "  option http-keep-alive\n  http-reuse always\n"

                               "frontend public\n  bind " +
                                   listen +
                                   "\n  default_backend servers\n"
                                   "backend servers\n" +
                                   "  option httpchk GET /readyz\n" + list)};
  } else {
    log_ = folder_ / "access.log";
    std::string temporary;
    for (const char* kind_of : {"client_body", "proxy", "fastcgi", "uwsgi", "scgi"})
      temporary += std::string(kind_of) + "_temp_path " + (folder_ / kind_of) + ";\n";
    arguments = {
        program,
        "-p",
        folder_ / "",
        "-e",
        folder_ / "error.log",
        "-c",
        folder_.write("nginx.conf",
                      "daemon off;\nmaster_process off;\npid " + (folder_ / "pid") +
                          ";\nevents {}\nhttp {\n" + temporary +
                          "log_format counts 'request $upstream_bytes_sent $status';\n"
                          "access_log " +
                          log_ +
                          " counts;\n"
                          "client_header_timeout 2s;\nclient_body_timeout 2s;\nkeepalive_timeout 2s;\n"
                          "client_max_body_size 16m;\n"
                          "upstream servers { server 127.0.0.1:" +
                          std::to_string(servers.front().port) +
                          "; keepalive 8; }\n"
                          "server {\nlisten " +
                          listen +
                          ";\nlocation / {\n"
                          "proxy_pass http://servers;\nproxy_http_version 1.1;\n"
                          "proxy_set_header Connection \"\";\nproxy_next_upstream off;\n}\n}\n}\n")};
  }
  process_ = std::make_unique<ChildProcess>(arguments, folder_ / "output");
  require_eventually(kPatience, std::string(name(kind)) + " to listen", [&] {
    if (!process_->alive())
      throw std::runtime_error(std::string(name(kind)) + ": " + read_file(folder_ / "output"));
    try {
      RawClient probe(port);
      return true;
    } catch (const std::runtime_error&) {
      return false;
    }
  });
}

Proxy::Counts Proxy::counts() const {
  Counts counts;
  std::istringstream lines(read_file(log_));
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string word, upstream;
    if (!(words >> word >> upstream) || word != "request") continue;
    ++counts.seen;
    if (upstream != "-" && upstream != "-1") ++counts.sent_on;
  }
  return counts;
}

}  // namespace fracture::test
