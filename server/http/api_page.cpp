// Files for browsers: the page, the documents, and the files that they load.
#include "server/http/accept.hpp"
#include "server/http/api.hpp"
#include "server/http/content_coding.hpp"
#include "server/http/result_response.hpp"
#include "server/page/page.hpp"

namespace fracture::http {
namespace {

/// Content security policy: scripts, styles and pictures only from this server, no requests to other servers,
/// and no embedding in frames. WebAssembly is needed for the page's physics.
constexpr const char* kPolicy =
    "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; worker-src 'self' blob:; "
    "img-src 'self' blob: data:; connect-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'";

constexpr const char* kWithout =
    "<!DOCTYPE html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>fracture-server</title>\n"
    "<h1>fracture-server</h1>\n<p>POST a mesh to <code>/fracture</code> and get exact, watertight fragments back as one "
    "GLB.</p>\n<p>This server was built without its page, because npm was missing. Everything else works: see "
    "<a href=\"/openapi.json\">the interface</a>, <a href=\"/limits\">limits and parameters</a>, and "
    "<a href=\"/patterns\">patterns and materials</a>.</p>\n</html>\n";

Response page_response(const page::File& file, const RequestHead& head) {
  const bool packed = coding_wishes(head.field("accept-encoding")).accepts(ContentCoding::kGzip);
  const std::string etag = '"' + std::string(file.digest) + (packed ? "-gzip" : "") + '"';
  Response response;
  const std::string known = head.field("if-none-match");
  if (!known.empty() && names_etag(known, etag, Comparison::kWeak)) {
    response.status = 304;
  } else {
    response.content_type = file.media_type;
    response.body = packed ? file.gzip : file.plain;
    if (packed) response.headers.emplace_back("Content-Encoding", "gzip");
  }
  response.headers.emplace_back("ETag", etag);
  response.headers.emplace_back("Cache-Control",
                                "no-cache");  // browsers revalidate; the usual answer is 304
  response.headers.emplace_back("Vary", "Accept, Accept-Encoding");
  response.headers.emplace_back("Content-Security-Policy", kPolicy);
  // Other sites do not learn which page a user came from. "no-referrer" would also hide it from /docs, which
  // links back to the page.
  response.headers.emplace_back("Referrer-Policy", "same-origin");
  return response;
}

/// Returns a response that refers to bytes which live as long as the server.
Response sample_response(const std::string& bytes, std::string type) {
  Response response;
  response.content_type = std::move(type);
  response.body = {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
  response.headers.emplace_back("Cache-Control", "no-cache");
  response.headers.emplace_back("Content-Security-Policy", kPolicy);
  return response;
}

}  // namespace

bool is_page(Operation operation, const RequestHead& head) {
  if (operation == Operation::kGetIndex) {
    const auto chosen = negotiate(head.field("accept"), kIndexTypes);
    return chosen && *chosen == kIndexAsHtml;
  }
  return operation == Operation::kGetDocs || operation == Operation::kGetPageFile;
}

OrProblem<Response> Api::get_page(const Request& request, std::string_view path) const {
  const page::File* const file = page_ ? page::find(path) : nullptr;
  if (file) return page_response(*file, request.head);
  if (page_ && path == page::kSampleList) return sample_response(samples_.list(), "application/json");
  if (const std::string* const sample = page_ ? samples_.find(path) : nullptr)
    return sample_response(*sample, "application/octet-stream");
  if (page_ && page::files().empty() && request.admission.route->operation == Operation::kGetIndex) {
    Response response = Response::text(200, "text/html; charset=utf-8", kWithout);
    response.headers.emplace_back("Content-Security-Policy", "default-src 'none'");
    response.headers.emplace_back("Vary", "Accept");
    return response;
  }
  return refuse(HttpProblem::kNotFound,
                !page_                  ? "This server does not offer the web page (--no-page)."
                : page::files().empty() ? "This server was built without its page."
                                        : "The page has no file '" + std::string(path.substr(0, 100)) + "'.");
}

}  // namespace fracture::http
