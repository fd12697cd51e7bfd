-- Submits the job in GRASPD_BODY over and over, and writes a row of a Markdown table in the end.
wrk.method = "POST"
wrk.body = os.getenv("GRASPD_BODY")
wrk.headers["Content-Type"] = "application/json"
if os.getenv("GRASPD_API_KEY") then
    wrk.headers["Authorization"] = "Bearer " .. os.getenv("GRASPD_API_KEY")
end

function done(summary, latency)
    local seconds = summary.duration / 1e6
    io.stderr:write(string.format("| durable submissions | %d | %.2f | %.2f | %.2f | %.0f a second; %d refused |\n",
        summary.requests, latency:percentile(50) / 1e3, latency:percentile(99) / 1e3, latency.max / 1e3,
        (summary.requests - summary.errors.status) / seconds, summary.errors.status))
end
