#pragma once

#include <chrono>
#include <functional>
#include <stdexcept>
#include <string>
#include <thread>

namespace truepose {

/// Looks again and again whether something came about in another process or thread that tells nobody. Throws
/// after five minutes, in which whatever is waited for comes about on any machine.
/// @param what   "the program has ended", for the message
/// @param shown  what there is instead, for the message
inline void await(
    const std::string& what, const std::function<bool()>& came_about,
    const std::function<std::string()>& shown = [] { return std::string{}; }) {
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::minutes{5};
  while (!came_about()) {
    if (std::chrono::steady_clock::now() > give_up)
      throw std::runtime_error{"waited for five minutes and in vain until " + what + "; " + shown()};
    std::this_thread::sleep_for(std::chrono::milliseconds{10});
  }
}

}  // namespace truepose
