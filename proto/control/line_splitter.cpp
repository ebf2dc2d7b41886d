#include "proto/control/line_splitter.hpp"

namespace truepose::control {

void LineSplitter::push(std::string_view bytes) {
  buffer_.erase(0, begin_);
  begin_ = 0;
  buffer_.append(bytes);
}

std::optional<std::string> LineSplitter::next() {
  while (true) {
    const auto end = buffer_.find('\n', begin_);
    if (end == std::string::npos || end - begin_ > max_line_) return std::nullopt;
    std::string line = buffer_.substr(begin_, end - begin_);
    begin_ = end + 1;
    if (line.ends_with('\r')) line.pop_back();
    if (!line.empty()) return line;
  }
}

bool LineSplitter::overflowed() const {
  const auto end = buffer_.find('\n', begin_);
  return (end == std::string::npos ? buffer_.size() : end) - begin_ > max_line_;
}

}  // namespace truepose::control
