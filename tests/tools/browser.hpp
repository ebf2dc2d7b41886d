#pragma once

#include <string>
#include <vector>

namespace truepose {

/// What a browser made of a page.
struct Browsed {
  std::string dom;                   ///< after its scripts ran
  std::vector<std::string> console;  ///< errors, failed loads and whatever else it said there
};

/// Opens a page from the disk in headless Chromium, with a profile of its own.
Browsed browse(std::string html);

}  // namespace truepose
