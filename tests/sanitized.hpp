#pragma once

// TRUEPOSE_SANITIZED: 1 where the address or the thread sanitizer watches. It has taken malloc for itself
// then, and what computes takes ten to fifty times as long. g++ and clang say it in words of their own.
#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define TRUEPOSE_SANITIZED 1
#endif
#elif defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define TRUEPOSE_SANITIZED 1
#endif
#ifndef TRUEPOSE_SANITIZED
#define TRUEPOSE_SANITIZED 0
#endif
