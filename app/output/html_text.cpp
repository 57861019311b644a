#include "app/output/html_text.h"

#include <array>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

namespace pathfit::app {
namespace {

constexpr std::string_view kReplacement = "\xef\xbf\xbd";

/// Bytes of the UTF-8 character at the front of `text`, 0 when it is not one.
std::size_t CharacterLength(std::string_view text) {
  const auto byte = [&text](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned lead = byte(0);
  if (lead < 0x80U) return 1;
  const std::size_t length = lead >= 0xf5U   ? 0
                             : lead >= 0xf0U ? 4
                             : lead >= 0xe0U ? 3
                             : lead >= 0xc2U ? 2
                                             : 0;
  if (length == 0 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0U) != 0x80U) return 0;
  }
  const unsigned second = byte(1);
  const bool overlong = (lead == 0xe0U && second < 0xa0U) || (lead == 0xf0U && second < 0x90U);
  const bool no_character = (lead == 0xedU && second > 0x9fU) || (lead == 0xf4U && second > 0x8fU);
  return overlong || no_character ? 0 : length;
}

std::string Superscript(int number) {
  constexpr std::array<std::string_view, 10> kDigits = {
      "⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text = number < 0 ? "⁻" : "";
  for (const char c : std::to_string(std::abs(number))) {
    text += kDigits[static_cast<std::size_t>(c - '0')];
  }
  return text;
}

}  // namespace

std::string EscapeHtml(const std::string& text) {
  std::string escaped;
  escaped.reserve(text.size());
  for (std::string_view rest = text; !rest.empty();) {
    const std::size_t length = CharacterLength(rest);
    const char c = rest.front();
    const auto byte = static_cast<unsigned char>(c);
    if (length == 0 || byte == 0x7f || (byte < 0x20 && c != '\n' && c != '\t' && c != '\r')) {
      escaped += kReplacement;
    } else if (c == '&') {
      escaped += "&amp;";
    } else if (c == '<') {
      escaped += "&lt;";
    } else if (c == '>') {
      escaped += "&gt;";
    } else if (c == '"') {
      escaped += "&quot;";
    } else if (c == '\'') {
      escaped += "&#39;";
    } else {
      escaped.append(rest.substr(0, length));
    }
    rest.remove_prefix(length == 0 ? 1 : length);
  }
  return escaped;
}

std::string NumberText(double value) {
  if (std::isnan(value)) return "–";
  if (std::isinf(value)) return value > 0.0 ? "∞" : "−∞";
  if (value == 0.0) return "0";
  const std::string sign = value < 0.0 ? "−" : "";
  const double size = std::abs(value);
  if (size >= 1e-3 && size < 99999.5) return sign + fmt::format("{:.4g}", size);
  const std::string scientific = fmt::format("{:.3e}", size);
  const std::size_t e = scientific.find('e');
  std::string mantissa = scientific.substr(0, e);
  mantissa.erase(mantissa.find_last_not_of('0') + 1);
  if (mantissa.back() == '.') mantissa.pop_back();
  const std::string power = "10" + Superscript(std::stoi(scientific.substr(e + 1)));
  return sign + (mantissa == "1" ? power : mantissa + "·" + power);
}

std::string FixedText(double value, int digits, const std::string& unit) {
  if (!std::isfinite(value)) return "–";
  std::string text = fmt::format("{:.{}f}", std::abs(value), digits);
  if (value < 0.0 && text.find_first_not_of("0.") != std::string::npos) text = "−" + text;
  return unit.empty() ? text : text + " " + unit;
}

std::string BytesText(double bytes) {
  if (!std::isfinite(bytes)) return "–";
  if (bytes >= 999.5e6) return fmt::format("{:.2f} GB", bytes * 1e-9);
  if (bytes >= 999.5e3) return fmt::format("{:.1f} MB", bytes * 1e-6);
  return fmt::format("{:.0f} kB", std::ceil(bytes * 1e-3));
}

}  // namespace pathfit::app
