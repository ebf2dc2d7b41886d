#pragma once

#include <cstddef>
#include <expected>
#include <optional>
#include <string>
#include <string_view>

namespace truepose::eki {

/// Cuts XML documents out of a byte stream that has neither lengths nor terminators: a document ends with the
/// closing tag of its root. White space, NUL and other bytes between documents are skipped up to the next
/// '<'.
class DocumentSplitter {
 public:
  /// The controller's own limit on one document (BUFFSIZE).
  static constexpr std::size_t kMaxDocumentBytes = 64 * 1024;

  void feed(std::string_view bytes);

  /// The next complete document, empty if more bytes are needed.
  /// Error: a document above the limit; reset() before going on.
  std::expected<std::optional<std::string>, std::string> next();

  /// Forgets what has been fed.
  void reset();

 private:
  enum class Where { Between, Content, TagStart, Tag, Quoted, Comment, Instruction };

  bool step(char c);
  bool end_tag(std::string_view tag);
  void begin_here();
  void discard();

  std::string buffer_;
  std::size_t scanned_ = 0;  // bytes of buffer_ that have been stepped through
  Where where_ = Where::Between;
  std::size_t tag_begin_ = 0;
  char quote_ = 0;
  std::size_t depth_ = 0;
};

}  // namespace truepose::eki
