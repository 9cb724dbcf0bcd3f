#include "server/import_worker/protocol.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/uio.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>

#include "common/base/wait_for.hpp"
#include "server/import_worker/byte_stream.hpp"

namespace fracture {
namespace {

constexpr std::size_t kMaxDescriptors = 2;
/// How often a waiting import checks whether it is still wanted.
constexpr std::chrono::milliseconds kBetweenPolls(10);
/// Buffer for one control message, with the alignment that the kernel requires.
struct alignas(cmsghdr) Control {
  char bytes[CMSG_SPACE(kMaxDescriptors * sizeof(int))];
};

}  // namespace

std::vector<std::byte> input_head(std::span<const std::byte> mesh, std::span<const ImportFile> files) {
  ByteWriter out;
  out.value<std::uint64_t>(mesh.size());
  out.value<std::uint64_t>(files.size());
  for (const ImportFile& file : files) {
    out.text(file.name);
    out.value<std::uint64_t>(file.bytes.size());
  }
  std::vector<std::byte> head = out.take();
  head.resize(aligned(head.size()));
  return head;
}

std::optional<ImportJob> parse_request(const ImportRequest& request, std::span<const std::byte> input) {
  if (request.version != kProtocolVersion || request.format >= all_formats().size()) return std::nullopt;
  ImportJob job;
  job.format = static_cast<MeshFormat>(request.format);
  job.limits = {request.max_triangles, request.max_decoded_bytes, request.max_json_depth};
  ByteReader in(input);
  const auto mesh_bytes = in.value<std::uint64_t>();
  job.files.resize(in.length(2 * sizeof(std::uint64_t)));
  std::vector<std::uint64_t> sizes;
  for (ImportFile& file : job.files) {
    file.name = in.text();
    sizes.push_back(in.value<std::uint64_t>());
  }
  const auto fill_up = [&] { (void)in.view(aligned(input.size() - in.left()) - (input.size() - in.left())); };
  const auto part = [&](std::uint64_t size) {
    fill_up();
    return in.view(size);
  };
  job.mesh = part(mesh_bytes);
  for (std::size_t k = 0; k < sizes.size(); ++k) job.files[k].bytes = part(sizes[k]);
  fill_up();
  return in.at_end() ? std::optional(std::move(job)) : std::nullopt;
}

bool send_message(int socket, const void* message, std::size_t size, std::span<const int> descriptors) {
  iovec part{const_cast<void*>(message), size};
  msghdr header{};
  header.msg_iov = &part;
  header.msg_iovlen = 1;
  Control control{};
  if (!descriptors.empty()) {
    const std::size_t bytes = std::min(descriptors.size(), kMaxDescriptors) * sizeof(int);
    header.msg_control = control.bytes;
    header.msg_controllen = CMSG_SPACE(bytes);
    cmsghdr* rights = CMSG_FIRSTHDR(&header);
    rights->cmsg_level = SOL_SOCKET;
    rights->cmsg_type = SCM_RIGHTS;
    rights->cmsg_len = CMSG_LEN(bytes);
    std::memcpy(CMSG_DATA(rights), descriptors.data(), bytes);
  }
  ssize_t sent = 0;
  do sent = ::sendmsg(socket, &header, MSG_NOSIGNAL);
  while (sent < 0 && errno == EINTR);
  return sent == static_cast<ssize_t>(size);
}

Received receive_message(int socket, void* message, std::size_t size) {
  iovec part{message, size};
  msghdr header{};
  header.msg_iov = &part;
  header.msg_iovlen = 1;
  Control control{};
  header.msg_control = control.bytes;
  header.msg_controllen = sizeof control.bytes;
  ssize_t got = 0;
  do got = ::recvmsg(socket, &header, MSG_CMSG_CLOEXEC);
  while (got < 0 && errno == EINTR);
  Received received;
  if (got < 0) return received;
  received.whole = got == static_cast<ssize_t>(size) && (header.msg_flags & (MSG_TRUNC | MSG_CTRUNC)) == 0;
  for (cmsghdr* c = CMSG_FIRSTHDR(&header); c != nullptr; c = CMSG_NXTHDR(&header, c))
    if (c->cmsg_level == SOL_SOCKET && c->cmsg_type == SCM_RIGHTS)
      std::memcpy(received.descriptors, CMSG_DATA(c),
                  std::min(c->cmsg_len - CMSG_LEN(0), sizeof received.descriptors));
  return received;
}

bool wait_for_message(int socket, const Execution& execution) {
  for (;;) {
    const short ready = wait_for(socket, POLLIN, std::chrono::steady_clock::now() + kBetweenPolls);
    if (ready != 0) return (ready & POLLIN) != 0;
    if (errno != ETIMEDOUT) return false;
    execution.poll();
  }
}

}  // namespace fracture
