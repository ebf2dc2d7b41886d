#pragma once

#include <boost/system/error_code.hpp>
#include <cstdint>
#include <stdexcept>
#include <string>

namespace truepose::sim {

/// A port that cannot be listened on. what() is the operator's line: which, why, and what to do.
class PortError : public std::runtime_error {
 public:
  PortError(const std::string& whose, std::uint16_t port, const boost::system::error_code& reason)
      : std::runtime_error{
            whose + " port " + std::to_string(port) + ": " + reason.message() +
            "; choose another, or see who holds it: ss -ltnp 'sport = :" + std::to_string(port) + "'"} {}
};

}  // namespace truepose::sim
