// CAN frames of the arm ↔ structs, without I/O: CiA 301/402 as in controller.md §4, all values little-endian.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

namespace armsight {

/// A CAN 2.0 data frame with an 11-bit identifier; or one of CAN FD with its bit rate switched and no more data.
struct CanFrame {
  std::uint32_t id = 0;
  std::uint8_t size = 0;  ///< 0 … 8
  std::array<std::uint8_t, 8> data{};
  bool is_fd = false;

  friend bool operator==(const CanFrame&, const CanFrame&) = default;
};

inline constexpr std::uint8_t kControllerNode = 127;
inline constexpr std::uint32_t kNmtId = 0x000, kSyncId = 0x080, kEmcyBase = 0x080, kTpdo1Base = 0x180,
                               kRpdo1Base = 0x200, kSdoAnswerBase = 0x580, kSdoRequestBase = 0x600,
                               kHeartbeatBase = 0x700;

enum class NmtCommand : std::uint8_t {
  kStart = 0x01, kStop = 0x02, kPreOperational = 0x80, kResetNode = 0x81, kResetCommunication = 0x82
};
enum class NmtState : std::uint8_t { kBootUp = 0x00, kStopped = 0x04, kOperational = 0x05, kPreOperational = 0x7F };

struct Nmt { NmtCommand command; std::uint8_t node; };            // node 0: all
struct Sync { std::uint8_t counter; };                            // 1 … 10; 0: a SYNC without the counter byte
struct Emcy { std::uint16_t code; std::uint8_t error_register; }; // 0x080 + node
struct Heartbeat { NmtState state; };                             // 0x700 + node
struct Tpdo1 { std::uint16_t statusword; std::int32_t position_counts; std::int16_t torque; };       // 0x180 + node
struct Rpdo1 { std::uint16_t controlword; std::int32_t target_counts; std::int16_t torque_offset; }; // 0x200 + node

CanFrame encode(const Nmt& m) noexcept;
CanFrame encode(const Sync& m) noexcept;
CanFrame encode(const Emcy& m, std::uint8_t node) noexcept;
CanFrame encode(const Heartbeat& m, std::uint8_t node) noexcept;
CanFrame encode(const Tpdo1& m, std::uint8_t node) noexcept;
CanFrame encode(const Rpdo1& m, std::uint8_t node) noexcept;

/// nullopt: the identifier, the size, or a code that must be one of a list (NMT command, NMT state) does not fit.
std::optional<Nmt> decode_nmt(const CanFrame& f) noexcept;
std::optional<Sync> decode_sync(const CanFrame& f) noexcept;
std::optional<Emcy> decode_emcy(const CanFrame& f, std::uint8_t node) noexcept;
std::optional<Heartbeat> decode_heartbeat(const CanFrame& f, std::uint8_t node) noexcept;
std::optional<Tpdo1> decode_tpdo1(const CanFrame& f, std::uint8_t node) noexcept;
std::optional<Rpdo1> decode_rpdo1(const CanFrame& f, std::uint8_t node) noexcept;

// SDO, expedited (controller.md §4.2).
struct ObjectAddress {
  std::uint16_t index = 0;
  std::uint8_t sub = 0;
  friend bool operator==(const ObjectAddress&, const ObjectAddress&) = default;
};
struct SdoRead { ObjectAddress object; };
struct SdoWrite { ObjectAddress object; std::uint32_t value; std::uint8_t size; };  // size 1 … 4 bytes
struct SdoReadAnswer { ObjectAddress object; std::uint32_t value; std::uint8_t size; };
struct SdoWriteAnswer { ObjectAddress object; };
struct SdoAbort { ObjectAddress object; std::uint32_t code; };

CanFrame encode(const SdoRead& m, std::uint8_t node) noexcept;
CanFrame encode(const SdoWrite& m, std::uint8_t node) noexcept;
CanFrame encode(const SdoReadAnswer& m, std::uint8_t node) noexcept;
CanFrame encode(const SdoWriteAnswer& m, std::uint8_t node) noexcept;
CanFrame encode_request_abort(const SdoAbort& m, std::uint8_t node) noexcept;
CanFrame encode_answer_abort(const SdoAbort& m, std::uint8_t node) noexcept;
std::optional<SdoRead> decode_sdo_read(const CanFrame& f, std::uint8_t node) noexcept;
std::optional<SdoWrite> decode_sdo_write(const CanFrame& f, std::uint8_t node) noexcept;
std::optional<SdoReadAnswer> decode_sdo_read_answer(const CanFrame& f, std::uint8_t node) noexcept;
std::optional<SdoWriteAnswer> decode_sdo_write_answer(const CanFrame& f, std::uint8_t node) noexcept;
std::optional<SdoAbort> decode_sdo_answer_abort(const CanFrame& f, std::uint8_t node) noexcept;
/// Meaning of an abort code of CiA 301; "unknown SDO abort code" for others.
const char* sdo_abort_text(std::uint32_t code) noexcept;

// CiA 402.
enum class DriveState : std::uint8_t {
  kNotReady, kSwitchOnDisabled, kReadyToSwitchOn, kSwitchedOn, kOperationEnabled, kQuickStopActive, kFaultReaction,
  kFault, kUnknown
};
/// State from the statusword: mask 0x4F for the states whose bit 5 is undefined, else 0x6F (controller.md §4.4).
DriveState drive_state(std::uint16_t statusword) noexcept;
const char* to_text(DriveState state) noexcept;
inline constexpr std::uint16_t kShutdown = 0x06, kSwitchOn = 0x07, kEnableOperation = 0x0F, kQuickStop = 0x02,
                               kDisableVoltage = 0x00, kFaultReset = 0x80;

/// Worst-case bits on the wire of a frame with `size` data bytes, stuffing included (controller.md §3.2).
constexpr int worst_case_bits(int size) noexcept { return 8 * size + 47 + (34 + 8 * size - 1) / 4; }

/// The same of a CAN FD frame of up to 16 bytes: bits at the arbitration's rate, and at the data's.
struct FdBits {
  int arbitration, data;
};
constexpr FdBits worst_case_fd_bits(int size) noexcept {
  constexpr int kHead = 17, kTail = 13;   // up to the switch of the rate; from the CRC's delimiter on
  constexpr int kCheck = 4 + 17 + 6;      // stuff count, CRC, their fixed stuff bits
  const int stuffable = kHead + 5 + 8 * size, stuffed_head = (kHead - 1) / 4;
  return {kHead + stuffed_head + kTail, 5 + 8 * size + kCheck + (stuffable - 1) / 4 - stuffed_head};
}

/// Bit rates of a bus; classic frames know the first alone.
struct BusRates {
  double bitrate_bit_s = 1e6, data_bitrate_bit_s = 5e6;
};
/// Longest time on the wire.
constexpr double worst_case_s(int size, bool is_fd, const BusRates& rates) noexcept {
  if (!is_fd) return worst_case_bits(size) / rates.bitrate_bit_s;
  const FdBits bits = worst_case_fd_bits(size);
  return bits.arbitration / rates.bitrate_bit_s + bits.data / rates.data_bitrate_bit_s;
}

}  // namespace armsight
