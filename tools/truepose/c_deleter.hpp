#pragma once

namespace truepose::tools {

/// Deleter of what a C library wants back by a function of its own.
template <auto Free>
struct CDeleter {
  void operator()(auto* x) const { Free(x); }
};

}  // namespace truepose::tools
