#include "arm_controller/build_id.hpp"

#include <link.h>

#include <cstring>

namespace armsight::arm {
namespace {

constexpr std::uint32_t kGnuBuildId = 3;  // NT_GNU_BUILD_ID

std::string find_in_notes(const char* at, const char* end) {
  while (at + sizeof(ElfW(Nhdr)) <= end) {
    const auto* note = reinterpret_cast<const ElfW(Nhdr)*>(at);
    const char* name = at + sizeof *note;
    const char* text = name + ((note->n_namesz + 3u) & ~3u);
    if (note->n_type == kGnuBuildId && note->n_namesz == 4 && std::memcmp(name, "GNU", 4) == 0)
      return {text, text + note->n_descsz};
    at = text + ((note->n_descsz + 3u) & ~3u);
  }
  return {};
}

// The first object that is listed is the executable itself.
int look_at_first(dl_phdr_info* info, std::size_t, void* result) {
  for (int i = 0; i < info->dlpi_phnum; ++i) {
    if (info->dlpi_phdr[i].p_type != PT_NOTE) continue;
    const char* begin = reinterpret_cast<const char*>(info->dlpi_addr + info->dlpi_phdr[i].p_vaddr);
    const std::string found = find_in_notes(begin, begin + info->dlpi_phdr[i].p_memsz);
    if (!found.empty()) *static_cast<std::string*>(result) = found;
  }
  return 1;
}

}  // namespace

std::string build_id() {
  std::string bytes, text;
  dl_iterate_phdr(look_at_first, &bytes);
  for (const char byte : bytes) {
    constexpr const char* kDigits = "0123456789abcdef";
    const auto value = static_cast<unsigned char>(byte);
    text += kDigits[value >> 4];
    text += kDigits[value & 15];
  }
  return text;
}

}  // namespace armsight::arm
