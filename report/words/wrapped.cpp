#include "report/words/wrapped.h"

#include <algorithm>

namespace sixdial::report {
namespace {

constexpr std::size_t kWidth = 96;

}  // namespace

std::string wrapped(const std::string& text, const std::string& indent) {
  std::string out = indent;
  std::size_t used = indent.size();
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    const auto width = static_cast<std::size_t>(std::ranges::count_if(
        word, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
    if (used > indent.size() && used + 1 + width > kWidth) {
      out += "\n" + indent;
      used = indent.size();
    } else if (used > indent.size()) {
      out += ' ';
      ++used;
    }
    out += word;
    used += width;
    begin = end + 1;
  }
  return out + "\n";
}

}  // namespace sixdial::report
