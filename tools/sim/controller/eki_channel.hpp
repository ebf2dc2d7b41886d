#pragma once

#include <cstddef>
#include <deque>
#include <expected>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tools/sim/controller/eki_file.hpp"
#include "tools/sim/krl/value.hpp"

namespace truepose::sim {

/// One channel of Ethernet KRL: what lies between the program and the documents on the wire. No I/O.
///
/// After a lost connection only clear, init and open together make it usable again.
class EkiChannel {
 public:
  explicit EkiChannel(EkiFile file) : file_{std::move(file)} {}

  const EkiFile& file() const { return file_; }

  // The program's side.
  void clear();
  void init() { is_initialised_ = true; }
  /// @return false where it was not initialised, or not cleared after a loss
  bool open();
  bool is_initialised() const { return is_initialised_; }
  /// Values of an element that wait to be taken.
  std::size_t waiting(std::string_view tag) const;
  /// The oldest of them. Errors: there is none, or the file does not have the element with this type.
  std::expected<krl::Value, std::string> take(std::string_view tag, EkiFile::Type type);
  /// Deletes the waiting values of an element and of all below it.
  void clear_buffer(std::string_view element);
  /// Fills in an element of the next document, which keeps it afterwards. A frame fills the element's
  /// attributes X, Y, Z, A, B and C. Errors: the file does not have it.
  std::expected<void, std::string> set(std::string_view tag, krl::Value value);
  /// The document of an element and all below it, in their parents. Errors: the file has none of them.
  std::expected<std::string, std::string> document(std::string_view element) const;

  // The wire's side.
  bool is_open() const { return is_open_; }
  bool is_connected() const { return is_connected_; }
  void connect() { is_connected_ = true; }
  void disconnect();
  /// @return the flags that the document raises. Errors: what the controller shows; nothing of it is kept
  std::expected<std::vector<int>, std::string> receive(std::string_view document);

 private:
  EkiFile file_;
  bool is_initialised_ = false, is_open_ = false, is_connected_ = false;
  bool was_lost_ = false;
  std::map<std::string, std::deque<krl::Value>, std::less<>> received_;
  std::map<std::string, krl::Value, std::less<>> to_send_;

  bool sends(std::string_view tag) const;
  std::expected<void, std::string> set_frame(std::string_view tag, const krl::Parts& frame);
};

}  // namespace truepose::sim
