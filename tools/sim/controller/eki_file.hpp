#pragma once

#include <cstdint>
#include <expected>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace truepose::sim {

/// The configuration of one channel of Ethernet KRL, as the controller loads it. The file's name is the
/// channel's. PROTOCOL is TCP where it is missing; RECEIVE and SEND may be empty or missing.
struct EkiFile {
  enum class Type { Int, Real, Bool, String, Frame };
  struct Received {
    std::string tag;           ///< "Cmd/Ax/@A1"; of a frame its element, with the attributes X to C
    std::optional<Type> type;  ///< none: only its flag is raised
    std::optional<int> flag;   ///< raised when a document with this element has come
  };

  bool of_submit = false;         ///< ENVIRONMENT: the program at whose reset the channel is deleted
  std::size_t buffered = 16;      ///< values of each element that wait for the program
  std::optional<int> alive_flag;  ///< TRUE while a client is connected
  std::uint16_t port = 0;
  std::vector<Received> receive;
  std::vector<std::string> send;  ///< tags
};

/// Errors: one sentence on what in the file a controller could not use, or is not simulated.
std::expected<EkiFile, std::string> parse_eki_file(std::string_view xml);

}  // namespace truepose::sim
