#include "tests/certificates.hpp"

#include <algorithm>
#include <cctype>
#include <stdexcept>

#include "tests/process.hpp"

namespace truepose {

namespace {

std::string openssl(const std::vector<std::string>& arguments) {
  const Finished finished = run_program("/usr/bin/openssl", arguments);
  if (finished.exit_code != 0) throw std::runtime_error{"openssl: " + finished.err};
  return finished.out;
}

}  // namespace

void Certificates::make(const std::string& name) const {
  openssl({"req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-keyout",
           key(name), "-out", certificate(name), "-subj", "/CN=" + name, "-addext",
           "subjectAltName=DNS:localhost,IP:127.0.0.1", "-days", "100"});
  std::filesystem::permissions(key(name), std::filesystem::perms::owner_read);
}

void Certificates::end_in(const std::string& name, int days) const {
  openssl({"x509", "-in", certificate(name), "-signkey", key(name), "-days", std::to_string(days), "-out",
           certificate(name)});
}

std::string Certificates::fingerprint(const std::string& name) const {
  std::string said = openssl({"x509", "-in", certificate(name), "-noout", "-fingerprint", "-sha256"});
  said.erase(0, said.find('=') + 1);
  std::erase_if(said, [](unsigned char c) { return std::isxdigit(c) == 0; });
  std::ranges::transform(said, said.begin(), [](unsigned char c) { return std::tolower(c); });
  return said;
}

}  // namespace truepose
