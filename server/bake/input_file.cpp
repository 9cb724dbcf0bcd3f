#include "server/bake/input_file.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include "server/bake/output_path.hpp"
#include "server/bake/wait_for.hpp"

namespace fracture::bake {
namespace {

/// Reads until the end of the file. Returns false and sets errno on failure.
bool read_all(int fd, std::string& bytes, const std::stop_token& stop) {
  struct stat found {};
  if (::fstat(fd, &found) == 0 && S_ISREG(found.st_mode))
    bytes.reserve(static_cast<std::size_t>(found.st_size));
  std::array<char, 1 << 16> block;
  while (wait_for(fd, POLLIN, stop)) {
    const ssize_t n = ::read(fd, block.data(), block.size());
    if (n == 0) return true;
    if (n > 0)
      bytes.append(block.data(), static_cast<std::size_t>(n));
    else if (errno != EINTR && errno != EAGAIN)
      return false;
  }
  return false;
}

Expected<MeshFormat> format_of(const std::string& path, std::span<const std::byte> bytes,
                               const RequestParameters& parameters) {
  if (parameters.format) return *parameters.format;
  if (const std::string ending = std::filesystem::path(path).extension().string(); ending.size() > 1)
    if (const auto format = format_from_extension(ending.substr(1))) return *format;
  if (const auto format = format_from_content(bytes)) return *format;
  const std::string what = path == kStandardStream
                               ? "The first bytes of standard input do not identify the format"
                               : "The name '" + path + "' has no known file extension";
  return fail(ErrorCode::kUnknownFormat, what + "; give the format with --format.", "format");
}

}  // namespace

std::optional<std::string> read_bytes(const std::string& path, const std::stop_token& stop) {
  const bool standard = path == kStandardStream;
  // O_NONBLOCK: otherwise open() would block forever on a FIFO without a writer. wait_for() waits for data
  // and notices a stop.
  const int fd = standard ? STDIN_FILENO : ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) return std::nullopt;
  std::string bytes;
  const bool good = read_all(fd, bytes, stop);
  const int reason = errno;
  if (!standard) ::close(fd);
  errno = reason;
  if (!good) return std::nullopt;
  return bytes;
}

std::optional<std::string> fault_of_input(const std::string& path) {
  if (path == kStandardStream) return std::nullopt;
  struct stat found {};
  if (::stat(path.c_str(), &found) != 0 || ::faccessat(AT_FDCWD, path.c_str(), R_OK, AT_EACCESS) != 0)
    return std::strerror(errno);
  if (S_ISDIR(found.st_mode)) return std::strerror(EISDIR);
  return std::nullopt;
}

Expected<InputFile> to_input(const std::string& path, std::string bytes,
                             const RequestParameters& parameters) {
  if (bytes.empty())
    return fail(ErrorCode::kEmptyBody,
                (path == kStandardStream ? std::string("Standard input") : "'" + path + "'") +
                    " is empty (0 bytes): give a mesh file.");
  const Expected<MeshFormat> format = format_of(path, std::as_bytes(std::span(bytes)), parameters);
  if (!format) return tl::unexpected(format.error());
  InputFile input{std::move(bytes), *format};
  if (path != kStandardStream) input.siblings = read_sibling_files(path, input.view(), *format);
  return input;
}

}  // namespace fracture::bake
