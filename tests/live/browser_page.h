// Chromium with one page, driven through tests/live/drive.py.
#pragma once

#include <string>

#include "service/error.h"

namespace sixdial::testing {

class BrowserPage {
 public:
  BrowserPage();
  ~BrowserPage();
  BrowserPage(const BrowserPage&) = delete;
  BrowserPage& operator=(const BrowserPage&) = delete;

  void open(const std::string& url) { tell({{"open", url}}); }
  Json run(const std::string& javascript) { return tell({{"do", javascript}}); }
  /// Asks until it is true; throws std::runtime_error with the page's text after a minute.
  Json until(const std::string& javascript) { return tell({{"until", javascript}}); }
  void keys(const std::string& text) { tell({{"keys", text}}); }
  void click(const std::string& what) {
    run("document.querySelector('button[data-do=" + what + "]').click()");
  }
  /// Goes over to the tab whose address has this part, once it is there.
  void go_to_tab(const std::string& part) { tell({{"tab", part}}); }
  Json complaints() { return tell({{"complaints", true}}); }
  /// Of the tab that was gone over to, from its beginning.
  Json complaints_here() { return tell({{"complaints_here", true}}); }
  /// Throws std::runtime_error with what the driver says.
  Json tell(const Json& order);

 private:
  int to_ = -1, from_ = -1, pid_ = -1;
  std::string buffer_;
};

}  // namespace sixdial::testing
