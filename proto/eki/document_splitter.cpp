#include "proto/eki/document_splitter.hpp"

namespace truepose::eki {

void DocumentSplitter::feed(std::string_view bytes) { buffer_.append(bytes); }

void DocumentSplitter::reset() { *this = {}; }

std::expected<std::optional<std::string>, std::string> DocumentSplitter::next() {
  while (scanned_ < buffer_.size()) {
    const char c = buffer_[scanned_++];
    if (where_ != Where::Between && scanned_ > kMaxDocumentBytes) {
      --scanned_;
      return std::unexpected("no end of the document within " + std::to_string(kMaxDocumentBytes / 1024) +
                             " KiB");
    }
    if (step(c)) {
      std::string document = buffer_.substr(0, scanned_);
      discard();
      return document;
    }
  }
  if (where_ == Where::Between) discard();
  return std::nullopt;
}

/// Drops what has been scanned; the next document begins behind it.
void DocumentSplitter::discard() {
  buffer_.erase(0, scanned_);
  scanned_ = 0;
  depth_ = 0;
  where_ = Where::Between;
}

/// Makes the '<' just scanned the beginning of the document.
void DocumentSplitter::begin_here() {
  buffer_.erase(0, scanned_ - 1);
  scanned_ = 1;
  tag_begin_ = 0;
  where_ = Where::TagStart;
}

/// Takes one character. True if it was the last of a document.
bool DocumentSplitter::step(char c) {
  const std::string_view tag{buffer_.data() + tag_begin_, scanned_ - tag_begin_};
  switch (where_) {
    case Where::Between:
      if (c == '<') begin_here();
      break;
    case Where::Content:
      if (c == '<') {
        tag_begin_ = scanned_ - 1;
        where_ = Where::TagStart;
      }
      break;
    case Where::TagStart:  // behind '<'; what follows tells what it is
      where_ = c == '?' ? Where::Instruction : Where::Tag;
      if (c == '>') discard();
      break;
    case Where::Tag:
      if (tag == "<!--") {
        where_ = Where::Comment;
      } else if (c == '"' || c == '\'') {
        quote_ = c;
        where_ = Where::Quoted;
      } else if (c == '<' && depth_ == 0) {
        begin_here();  // what came before was a stale half tag
      } else if (c == '>') {
        return end_tag(tag);
      }
      break;
    case Where::Quoted:
      if (c == quote_) where_ = Where::Tag;
      break;
    case Where::Comment:
      if (tag.ends_with("-->") && tag.size() >= 7) where_ = Where::Content;
      break;
    case Where::Instruction:
      if (tag.ends_with("?>")) where_ = Where::Content;
      break;
  }
  return false;
}

/// True if `tag` ends the document.
bool DocumentSplitter::end_tag(std::string_view tag) {
  where_ = Where::Content;
  if (tag.starts_with("</")) {
    // Clients that always send blocks of one size leave the tail of an older document behind the new one.
    if (depth_ == 0) {
      discard();
      return false;
    }
    --depth_;
  } else if (!tag.ends_with("/>")) {
    ++depth_;
  }
  return depth_ == 0;
}

}  // namespace truepose::eki
