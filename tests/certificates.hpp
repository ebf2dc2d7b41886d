#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace truepose {

/// Certificates made by the program `openssl`, in a folder: NAME.pem and NAME.key.
class Certificates {
 public:
  explicit Certificates(std::filesystem::path folder) : folder_{std::move(folder)} {}

  /// One that vouches for itself, for "localhost" and 127.0.0.1, and holds for 100 days.
  void make(const std::string& name) const;
  /// Has it end in so many days; -1 is yesterday.
  void end_in(const std::string& name, int days) const;
  std::filesystem::path certificate(const std::string& name) const { return folder_ / (name + ".pem"); }
  std::filesystem::path key(const std::string& name) const { return folder_ / (name + ".key"); }
  /// SHA-256, 64 digits.
  std::string fingerprint(const std::string& name) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace truepose
