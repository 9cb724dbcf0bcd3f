// The requests of a bake: the server's address, and the encoding of a form.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/bake/form.hpp"
#include "server/bake/http_caller.hpp"
#include "server/http/multipart.hpp"

namespace fracture::bake {
namespace {

using testing::HasSubstr;

TEST(ServerUrl, IsHostAndPortOverHttp) {
  const auto read = [](const std::string& url) {
    const auto settings = parse_server_url(url);
    return settings ? settings->host + "|" + std::to_string(settings->port) : settings.error().detail;
  };
  EXPECT_EQ(read("http://farm"), "farm|80");
  EXPECT_EQ(read("http://127.0.0.1:8080/"), "127.0.0.1|8080");
  EXPECT_EQ(read("http://[::1]:65535"), "::1|65535");
  EXPECT_EQ(read("https://farm:8443"), "farm|8443");
  for (const char* wrong : {"", "farm:8080", "ftp://farm", "http://", "http://:80", "http://farm:",
                            "http://farm:0", "http://farm:65536", "http://farm:80x", "http://farm/bake",
                            "http://u@farm", "http://[::1", "http://[::1]80", "http://a b", "http://farm?x"})
    EXPECT_THAT(read(wrong), HasSubstr("http://host:port")) << wrong;
}

TEST(WriteForm, IsReadBackWhateverThePartsHold) {
  const std::string tricky = "--fracture-bake--\r\n--fracture-bake0\r\n";
  const std::vector<FormPart> parts{{.name = "mesh", .filename = "mesh.obj", .body = tricky},
                                    {.name = "params", .body = "{}"},
                                    {.name = "file", .filename = "a \"b\".png", .body = ""}};
  const Expected<Form> form = write_form(parts);
  ASSERT_TRUE(form);
  const auto boundary = http::multipart_boundary(form->content_type);
  ASSERT_TRUE(boundary);
  const auto read = http::parse_multipart(form->body, *boundary);
  ASSERT_TRUE(read) << read.error().detail;
  ASSERT_EQ(read->size(), parts.size());
  for (std::size_t k = 0; k < parts.size(); ++k) {
    EXPECT_EQ((*read)[k].name, parts[k].name);
    EXPECT_EQ((*read)[k].filename.value_or(""), parts[k].filename);
    EXPECT_EQ((*read)[k].body, parts[k].body);
  }
  const FormPart injected{.name = "file", .filename = "a\r\nX: y", .body = ""};
  EXPECT_FALSE(write_form(std::span(&injected, 1)));
}

}  // namespace
}  // namespace fracture::bake
