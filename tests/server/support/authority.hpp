// Certificates that the openssl program makes on the spot.
#pragma once

#include <string>
#include <vector>

#include "tests/server/support/child_process.hpp"
#include "tests/server/support/temporary_folder.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {

/// A separate certificate authority. Needs find_program("openssl").
class Authority {
 public:
  explicit Authority(const TemporaryFolder& folder, const std::string& name)
      : folder_(folder), name_(name), openssl_(find_program("openssl").value_or("")) {
    run({"req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "2",
         "-subj", "/CN=" + name, "-keyout", key(name), "-out", certificate(name)});
  }
  std::string certificate(const std::string& of) const { return folder_ / (of + ".crt"); }
  std::string key(const std::string& of) const { return folder_ / (of + ".key"); }
  /// Signs a certificate for `names`, which is the value of the extension subjectAltName.
  void sign(const std::string& of, const std::string& names) const {
    folder_.write(of + ".ext", "subjectAltName=" + names + "\n");
    run({"req", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-subj", "/CN=" + of,
         "-keyout", key(of), "-out", folder_ / (of + ".csr")});
    run({"x509", "-req", "-in", folder_ / (of + ".csr"), "-CA", certificate(name_), "-CAkey", key(name_),
         "-CAcreateserial", "-days", "2", "-extfile", folder_ / (of + ".ext"), "-out", certificate(of)});
  }

 private:
  void run(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), openssl_);
    ChildProcess process(arguments, folder_ / "openssl.log");
    require_eventually(kPatience, "openssl", [&] { return !process.alive(); });
    if (process.wait() != 0) throw std::runtime_error(read_file(folder_ / "openssl.log"));
  }
  const TemporaryFolder& folder_;
  const std::string name_, openssl_;
};

}  // namespace fracture::test
