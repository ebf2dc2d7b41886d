#pragma once

#include <chrono>
#include <expected>
#include <string>
#include <string_view>

struct x509_st;

namespace truepose::control {

/// What the daemon looks at of a certificate.
struct Certificate {
  std::string fingerprint;  ///< SHA-256 of the DER form, 64 digits
  std::string name;         ///< common name of its subject
  /// Seconds: the year 9999, which stands for no end (RFC 5280, 4.1.2.5), is beyond system_clock's range.
  std::chrono::sys_seconds from, until;
};

Certificate facts_of(const x509_st& certificate);

/// The first certificate of a PEM file. The error is one phrase.
std::expected<Certificate, std::string> read_certificate(std::string_view pem);

/// Why a certificate does not hold at a time, as one phrase: "is not valid before ..."; empty: it does.
std::string validity_fault(const Certificate& certificate, std::chrono::system_clock::time_point now);

}  // namespace truepose::control
