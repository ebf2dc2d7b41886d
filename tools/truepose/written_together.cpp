#include "tools/truepose/written_together.hpp"

#include "tools/truepose/unfinished_file.hpp"

namespace truepose::tools {

void write_together(const std::vector<TextFile>& files) {
  // What would keep a file from its place is found before the first takes its own.
  std::vector<UnfinishedFile> unfinished;
  for (const TextFile& file : files) {
    unfinished.emplace_back(file.path).stream() << file.text;
    unfinished.back().close();
  }
  for (UnfinishedFile& file : unfinished) file.take_place();
}

}  // namespace truepose::tools
