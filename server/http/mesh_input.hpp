// Reads the mesh and the parameters from a request body: raw, or a multipart form.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/parameters/parameters.hpp"
#include "server/http/message.hpp"
#include "server/service/request.hpp"
#include "server/service/service.hpp"

namespace fracture::http {

/// The body of a request with its memory reservation. Shared by everything that still needs the bytes.
struct Body {
  std::string bytes;
  MemoryBudget::Reservation reservation;
};

/// Reads the requested fracture. Its bytes are borrowed from the body, which it keeps alive. The parameters
/// in the query, the part `params` and the form fields are combined. `of` may only refer to answers that the
/// caller may see. Throws Interrupted.
OrProblem<FractureRequest> read_mesh_input(const Request& request, std::shared_ptr<const Body> body,
                                           FractureService& service, const Execution& execution,
                                           const FractureService::MaySee& may_see = {});

/// Returns 415 with the list of supported formats. `given`: the format that the client gave; may be empty.
Problem unknown_format(const FormatSet& formats, std::string_view given);

/// Converts a query for the parameter table.
std::vector<RawParameter> raw_parameters(const std::vector<std::pair<std::string, std::string>>& query);

}  // namespace fracture::http
