// The mesh and the parameters out of the body of a request: raw, or a multipart form.
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

/// The body of a request, shared by all who still need its bytes; its reservation goes with it.
struct Body {
  std::string bytes;
  MemoryBudget::Reservation reservation;
};

/// What is asked, with the bytes borrowed from (and owned by) the body. Parameters of the query, of the part
/// `params` and of form fields are taken together; `of` names only what the caller may see.
OrProblem<FractureRequest> read_mesh_input(const Request& request, std::shared_ptr<const Body> body,
                                           FractureService& service,
                                           const FractureService::MaySee& may_see = {});

/// 415 with the list of what is read; `given` is what the client said, may be empty.
Problem unknown_format(const FormatSet& formats, std::string_view given);

/// The query as the parameter table wants it.
std::vector<RawParameter> raw_parameters(const std::vector<std::pair<std::string, std::string>>& query);

}  // namespace fracture::http
