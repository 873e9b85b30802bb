// Dead reckoning with a covariance, from wheels and gyroscope: a localizer in a process of its own.
//
//     c++ -std=c++17 -O2 -o odometry examples/own_localizer/odometry.cpp
//     wherein run scenes/home.toml --subject ./odometry
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <string>
#include <vector>

// A number in the little-endian bytes of an MCAP record (https://mcap.dev/spec).
template <typename Number>
Number number(const std::string& bytes, size_t at) {
    Number value = 0;
    for (size_t i = sizeof(Number); i-- > 0;) value = Number(value << 8 | std::uint8_t(bytes.at(at + i)));
    return value;
}

// Reads exactly `size` bytes; false where the stream ends.
bool read(std::string& bytes, size_t size) {
    bytes.resize(size);
    return std::fread(bytes.data(), 1, size, stdin) == size;
}

// The numbers in the value of a key, which stands in the value of the key before it, and so on; none of a null.
std::vector<double> numbers(const std::string& json, std::initializer_list<const char*> keys) {
    size_t at = 0;
    for (const char* key : keys) {
        const std::string quoted = "\"" + std::string(key) + "\":";
        at = json.find(quoted, at) + quoted.size();
    }
    std::vector<double> found;
    int depth = 0;
    const char* text = json.c_str() + at;
    do {
        if (*text == '[') depth++, text++;
        else if (*text == ']') depth--, text++;
        else if (*text == ',') text++;
        else {
            char* end;
            const double value = std::strtod(text, &end);
            if (end == text) return {};
            found.push_back(value);
            text = end;
        }
    } while (depth > 0);
    return found;
}

double middle(double low, double high) { return (low + high) / 2; }

// Standard deviation for a value of which bounds are known: they are taken for 3σ.
double deviation(double low, double high) { return (high - low) / 6; }

struct Odometry {
    double radius_m[2], radius_share, track_m, track_share, turn_rad, slip_ratio, side_slip_ratio;
    bool has_gyro;
    double bias_rad_per_s, bias_sd_rad_per_s, scale, scale_sd;
    double mean[3], covariance[3][3];
    bool has_rolled;
    double ticks[2], stamp_s, gyro_turn_rad, gyro_span_s;

    explicit Odometry(const std::string& setup) {
        const auto radius = numbers(setup, {"robot", "wheels", "radius_m"});
        const auto track = numbers(setup, {"robot", "wheels", "track_m"});
        for (int wheel : {0, 1}) radius_m[wheel] = middle(radius[2 * wheel], radius[2 * wheel + 1]);
        radius_share = deviation(radius[0], radius[1]) / radius_m[0];
        track_m = middle(track[0], track[1]);
        track_share = deviation(track[0], track[1]) / track_m;
        turn_rad = 2 * std::acos(-1.0) / numbers(setup, {"robot", "wheels", "ticks_per_turn"})[0];
        slip_ratio = numbers(setup, {"robot", "wheels", "slip_ratio"})[0] / 3;
        side_slip_ratio = numbers(setup, {"robot", "wheels", "side_slip_ratio"})[0] / 3;
        has_gyro = setup.find("\"gyro\":null") == std::string::npos;
        if (has_gyro) {
            const auto bias = numbers(setup, {"robot", "gyro", "bias_rad_per_s"});
            const auto share = numbers(setup, {"robot", "gyro", "scale"});
            bias_rad_per_s = middle(bias[0], bias[1]), bias_sd_rad_per_s = deviation(bias[0], bias[1]);
            scale = middle(share[0], share[1]), scale_sd = deviation(share[0], share[1]);
        }
    }

    void start(const std::string& message) {
        const auto box = numbers(message, {"box"});
        std::memset(covariance, 0, sizeof covariance);
        for (int axis = 0; axis < 3; axis++) {
            mean[axis] = middle(box[2 * axis], box[2 * axis + 1]);
            covariance[axis][axis] = std::pow(deviation(box[2 * axis], box[2 * axis + 1]), 2);
        }
        has_rolled = false;
        stamp_s = gyro_turn_rad = gyro_span_s = 0;
    }

    // Adds the turn since the gyroscope's reading before.
    void turn(const std::string& reading) {
        const double now_s = numbers(reading, {"measured_s"})[0], span_s = now_s - stamp_s;
        stamp_s = now_s;
        gyro_turn_rad += span_s * (numbers(reading, {"rate_rad_per_s"})[0] - bias_rad_per_s) / scale;
        gyro_span_s += span_s;
    }

    // Moves on by the ticks since the wheels' reading before.
    void roll(const std::string& reading) {
        const auto now = numbers(reading, {"ticks"});
        double rolled_m[2];
        for (int wheel : {0, 1}) {
            rolled_m[wheel] = has_rolled ? radius_m[wheel] * turn_rad * (now[wheel] - ticks[wheel]) : 0;
            ticks[wheel] = now[wheel];
        }
        has_rolled = true;
        const double ahead_m = (rolled_m[0] + rolled_m[1]) / 2;
        double turned_rad = (rolled_m[1] - rolled_m[0]) / track_m;
        double turn_sd_rad = std::fabs(turned_rad) * track_share;
        turn_sd_rad += (std::fabs(rolled_m[0]) + std::fabs(rolled_m[1])) * radius_share / track_m;
        turn_sd_rad += std::fabs(ahead_m) * slip_ratio / track_m;
        if (gyro_span_s > 0) {
            turned_rad = gyro_turn_rad;
            turn_sd_rad = gyro_span_s * bias_sd_rad_per_s + std::fabs(turned_rad) * scale_sd;
            gyro_turn_rad = gyro_span_s = 0;
        }
        const double direction_rad = mean[2] + turned_rad / 2;
        const double cos = std::cos(direction_rad), sin = std::sin(direction_rad);
        const double step[3] = {ahead_m * cos, ahead_m * sin, turned_rad};
        for (int axis = 0; axis < 3; axis++) mean[axis] += step[axis];
        carry(step);
        // The errors last: their deviations are added, not their variances.
        const double ahead_sd_m = std::fabs(ahead_m) * (radius_share + slip_ratio);
        const double side_sd_m = std::fabs(ahead_m) * side_slip_ratio;
        const double sd[3] = {std::fabs(cos) * ahead_sd_m + std::fabs(sin) * side_sd_m,
                              std::fabs(sin) * ahead_sd_m + std::fabs(cos) * side_sd_m, turn_sd_rad};
        for (int axis = 0; axis < 3; axis++)
            covariance[axis][axis] += sd[axis] * (2 * std::sqrt(covariance[axis][axis]) + sd[axis]);
    }

    // P ← J·P·Jᵀ, with J = ∂(pose after)/∂(pose before).
    void carry(const double step[3]) {
        const double jacobian[3][3] = {{1, 0, -step[1]}, {0, 1, step[0]}, {0, 0, 1}};
        double product[3][3] = {}, carried[3][3] = {};
        for (int r = 0; r < 3; r++)
            for (int c = 0; c < 3; c++)
                for (int k = 0; k < 3; k++) product[r][c] += jacobian[r][k] * covariance[k][c];
        for (int r = 0; r < 3; r++)
            for (int c = 0; c < 3; c++)
                for (int k = 0; k < 3; k++) carried[r][c] += product[r][k] * jacobian[c][k];
        std::memcpy(covariance, carried, sizeof carried);
    }

    // Prints a row of three numbers; 17 digits give a double to the last bit.
    static void print(const double row[3], const char* after) {
        std::printf("[%.17g, %.17g, %.17g]%s", row[0], row[1], row[2], after);
    }

    void answer(const std::string& message) const {
        std::printf("{\"time_s\": %.17g, \"mean\": ", numbers(message, {"time_s"})[0]);
        print(mean, ", \"covariance\": [");
        print(covariance[0], ", ");
        print(covariance[1], ", ");
        print(covariance[2], "]}\n");
        std::fflush(stdout);
    }
};

int main() {
    std::map<unsigned, std::string> topics;
    std::string head, record;
    Odometry* odometry = nullptr;
    if (!read(head, 8)) return 1;  // the magic bytes
    while (read(head, 9) && read(record, number<std::uint64_t>(head, 1))) {
        if (head[0] == 4) {  // a channel: its number, that of its schema, its topic
            topics[number<std::uint16_t>(record, 0)] = record.substr(8, number<std::uint32_t>(record, 4));
        } else if (head[0] == 5) {  // a message: its channel, 20 bytes of numbers and times, its data
            const std::string& topic = topics[number<std::uint16_t>(record, 0)];
            const std::string data = record.substr(22);
            if (topic == "/wherein/setup") odometry = new Odometry(data);
            else if (topic == "/wherein/start") odometry->start(data);
            else if (topic == "/wherein/gyro") odometry->turn(data);
            else if (topic == "/wherein/wheels") odometry->roll(data);
            else if (topic == "/wherein/ask") odometry->answer(data);
        }
    }
    delete odometry;
}
