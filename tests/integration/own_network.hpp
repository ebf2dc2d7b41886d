#pragma once

#include <string>
#include <vector>

namespace truepose {

/// A network that nobody else has, for the thread that makes it and all that this starts, as long as it
/// lives. Its addresses are none of loopback's: connections between them are as those of other machines.
class OwnNetwork {
 public:
  /// @throw std::runtime_error where none can be made
  explicit OwnNetwork(const std::vector<std::string>& addresses);
  ~OwnNetwork();
  OwnNetwork(const OwnNetwork&) = delete;
  OwnNetwork& operator=(const OwnNetwork&) = delete;

  /// Whether this process may make networks, and has the program that gives them addresses.
  static bool possible();

 private:
  int before_;  ///< the network that the thread was in
};

}  // namespace truepose
