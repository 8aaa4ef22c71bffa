#!/bin/sh
# Runs as the first program of the virtual machine: three virtual cameras, the last of them
# multi-planar, the built tectum, and what must come of it. Says "ok NAME" or "FAIL NAME: why" for each
# check and "PNG NAME BASE64" for pictures that the host judges.
/bin/busybox mkdir -p /proc /sys /dev /tmp
/bin/busybox mount -t proc none /proc
/bin/busybox mount -t sysfs none /sys
/bin/busybox mount -t devtmpfs none /dev
/bin/busybox mount -t tmpfs none /tmp
export PATH=/usr/bin:/bin
cd /tmp || exit 1

ok() { echo "ok $1"; }
fail() {
    echo "FAIL $1: $2"
    head -c 1500 /tmp/err 2>/dev/null | sed 's/^/  | /'
}
# run NAME COMMAND...: what must succeed; stdout in /tmp/out, stderr in /tmp/err.
run() {
    name=$1
    shift
    if timeout 60 "$@" >/tmp/out 2>/tmp/err; then ok "$name"; else fail "$name" "exit code $?"; fi
}
# refused NAME WORDS COMMAND...: what must fail with one message that holds WORDS.
refused() {
    name=$1 words=$2
    shift 2
    if timeout 60 "$@" >/tmp/out 2>/tmp/err; then
        fail "$name" "it succeeded"
    elif grep -q "$words" /tmp/err && ! grep -q panicked /tmp/err; then
        ok "$name"
    else
        fail "$name" "no \"$words\""
    fi
}
# field NAME FILE: the first whole number of that name in a JSON file.
field() { grep -o "\"$1\":[0-9]*" "$2" | head -n 1 | grep -o '[0-9]*'; }
# counts EYE FIELD FILE: a counter of an eye.
counts() { sed -n "s/.*\"$1\":{\([^}]*\)}.*/{\1}/p" "$3" | sed -n "s/.*\"$2\":\([0-9]*\).*/\1/p"; }
# holds NAME WORDS FILE
holds() { if grep -q "$2" "$3"; then ok "$1"; else fail "$1" "no \"$2\""; fi; }
# equal NAME VALUE DUE
equal() { if [ "$2" = "$3" ]; then ok "$1 ($2)"; else fail "$1" "$2 where $3 was due"; fi; }
# least NAME VALUE BOUND
least() {
    if [ "${2:-0}" -ge "$3" ]; then ok "$1 ($2)"; else fail "$1" "$2 where at least $3 was due"; fi
}

for module in $(cat /modules/order); do
    case $module in
    vivid.ko) insmod /modules/vivid.ko n_devs=3 node_types=0x101,0x101,0x1 multiplanar=1,1,2 ;;
    *) insmod "/modules/$module" ;;
    esac
done
mkdir -p /dev/v4l/by-id
captures='' outputs=''
for node in /dev/video*; do
    if v4l2-ctl -d "$node" --info 2>/dev/null | sed '1,/Device Caps/d' | grep -q 'Video Capture'; then
        captures="$captures $node"
    else
        outputs="$outputs $node"
    fi
done
# shellcheck disable=SC2086
set -- $captures
A=$1 B=$2 MULTI=$3
# shellcheck disable=SC2086
set -- $outputs
OUT_A=$1 OUT_B=$2
ln -s "$A" /dev/v4l/by-id/left-eye
ln -s "$B" /dev/v4l/by-id/right-eye
L=/dev/v4l/by-id/left-eye R=/dev/v4l/by-id/right-eye
echo "cameras $A $B, multi-planar $MULTI, outputs $OUT_A $OUT_B"

run 'the list' tectum capture --list
if [ "$(grep -c by-id /tmp/out)" = 2 ]; then ok 'stable names'; else fail 'stable names' "$(cat /tmp/out)"; fi

holds 'the list states rates' ' Hz)' /tmp/out
holds 'the list states why a node is of no use' 'cannot be used' /tmp/out

# The test pattern in every format, without text over it.
for camera in "$A" "$B" "$MULTI"; do
    v4l2-ctl -d "$camera" --set-input=0 -c test_pattern=0,osd_text_mode=2 >/dev/null
done
for format in YUYV GREY RGB565 RGB3 NV12; do
    run "stills in $format" tectum capture "stills-$format" --left "$L" --right "$R" --stills \
        --frames 1 --frame-size 320x180 --pixel-format "$format" --rate 10
    echo "PNG $format $(base64 -w 0 "stills-$format/left/0001.png")"
done

# The same of a multi-planar device, which gives one plane or several.
for format in YUYV NV12; do
    run "multi-planar: stills in $format" tectum capture "multi-$format" --left "$MULTI" --stills \
        --frames 1 --frame-size 320x180 --pixel-format "$format" --rate 10
    echo "PNG $format/multi-planar $(base64 -w 0 "multi-$format/left/0001.png")"
done
run 'multi-planar: recording' tectum capture multi --left "$MULTI" --record y4m \
    --frame-size 320x180 --pixel-format GREY --rate 25 --frames 20 --json
equal 'multi-planar: frames' "$(field frames /tmp/out)" 20

# One device with both eyes side by side.
run 'side by side' tectum capture both --side-by-side "$L" --stills --frames 1 \
    --frame-size 320x360 --pixel-format YUYV --rate 10
for eye in left right; do
    echo "PNG YUYV/$eye $(base64 -w 0 "both/$eye/0001.png")"
done

# Refusals.
refused 'no such camera' 'no such camera' tectum capture x --left /dev/video77 --right "$R" --stills
refused 'not a camera' 'not a camera' tectum capture x --left "$OUT_A" --right "$R" --stills
refused 'no camera at all' 'not a camera' tectum capture x --left /dev/null --right "$R" --stills
refused 'the same twice' 'the same camera' tectum capture x --left "$L" --right "$A" --stills
refused 'MJPG' 'does not offer pixel format MJPG' tectum capture x --left "$L" --right "$R" \
    --stills --pixel-format MJPG
refused 'an odd size' 'does not offer' tectum capture x --left "$L" --right "$R" --stills \
    --frame-size 321x181
chmod 600 "$B" && chown 0 "$B"
refused 'no permission' 'no permission' as-nobody tectum capture x --left "$L" --right "$R" --stills
v4l2-ctl -d "$A" --stream-mmap >/dev/null 2>&1 &
streaming=$!
sleep 1
refused 'busy' 'busy' tectum capture x --left "$L" --right "$R" --stills
kill $streaming
wait $streaming 2>/dev/null
v4l2-ctl -d "$A" -c inject_vidioc_streamon_error=1 >/dev/null
refused 'a camera that does not start' 'starting failed' tectum capture x --left "$L" --right "$R" --stills
mkdir full && mount -t tmpfs -o size=8m none full
refused 'disk full' 'the disk is full' tectum capture full/x --left "$L" --right "$R" --record y4m --frames 2

# Two pairs of formats that differ.
refused 'different sizes' 'the two cameras differ' tectum capture x --left /left.y4m --right /small.y4m --stills

# Exposure and gain alike.
v4l2-ctl -d "$A" -c gain_automatic=0,gain=77 >/dev/null
run 'locking' tectum capture locked --left "$L" --right "$R" --stills --frames 1 --lock
if [ "$(v4l2-ctl -d "$B" -C gain)" = 'gain: 77' ]; then ok 'the same gain'; else
    fail 'the same gain' "$(v4l2-ctl -d "$B" -C gain)"
fi

# Faults, each with a stream of its own that goes on until it has seen enough.
stream() {
    tectum capture "$1" --left "$L" --right "$R" --record y4m --frame-size 320x180 \
        --pixel-format GREY --rate 25 --seconds "$2" --json >"$1.json" 2>"$1.err" &
    recorder=$!
    sleep 2
}
finish() {
    if wait $recorder; then ok "$1: goes on"; else
        cp "$1.err" /tmp/err
        fail "$1: goes on" "exit code $?"
    fi
    least "$1: pairs" "$(field frames "$1.json")" "$2"
}
fault() { v4l2-ctl -d "$A" -c "$1" >/dev/null 2>&1; }

stream lost 8
fault percentage_of_dropped_buffers=40
sleep 3
fault percentage_of_dropped_buffers=0
finish lost 20
least 'lost: counted' "$(counts left dropped lost.json)" 5
# The other eye lost nothing that was not counted either: both made as many frames, but for those on
# the way at either end.
made() { echo $(($(counts "$1" frames lost.json) + $(counts "$1" dropped lost.json))); }
apart=$(($(made left) - $(made right)))
if [ "${apart#-}" -le 4 ]; then ok "lost: all accounted for ($(made left), $(made right))"; else
    fail 'lost: all accounted for' "left made $(made left), right $(made right)"
fi

# Every frame is accounted for, to the last. The driver's numbers begin at 0, and the recording has them.
last() {
    tail -c 57700 "$2/$1.y4m" | tr -cd ' -~\n' | grep -o 'SEQ=[0-9]*' | tail -n 1 | grep -o '[0-9]*'
}
tectum capture counted --left "$L" --right "$R" --record y4m --frame-size 320x180 \
    --pixel-format GREY --rate 10 --frames 60 --json >counted.json 2>counted.err &
recorder=$!
sleep 3
fault percentage_of_dropped_buffers=40
finish counted 60
fault percentage_of_dropped_buffers=0
least 'counted: dropped' "$(counts left dropped counted.json)" 4
for eye in left right; do
    case $eye in left) place=1 ;; *) place=2 ;; esac
    alone=$(sed -n 's/.*"alone":\[\([0-9]*\),\([0-9]*\)\].*/\'$place'/p' counted.json)
    frames=$(counts $eye frames counted.json)
    equal "counted: $eye frames have a partner or are alone" "$frames" $((60 + alone))
    made=$((frames + $(counts $eye dropped counted.json)))
    equal "counted: $eye frames came or were dropped" "$made" $(($(last $eye counted) + 1))
done

stream marked 5
fault inject_v4l2_buf_flag_error=1
finish marked 10
least 'marked: counted' "$(counts left corrupt marked.json)" 1

stream fatal 9
fault inject_fatal_streaming_error=1
finish fatal 10
least 'fatal: came back' "$(counts left reconnects fatal.json)" 1

stream requeue 9
fault inject_vidioc_qbuf_error=1
finish requeue 10
least 'requeue: came back' "$(counts left reconnects requeue.json)" 1

# While its other node is open the driver stays away: for ten seconds.
stream away 18
sleep 10 <"$OUT_A" &
holder=$!
fault inject_vidioc_streamon_error=1
fault inject_vidioc_reqbufs_error=1
fault disconnect=1
sleep 6
before=$(wc -c <away/left.y4m)
sleep 3
equal 'away: nothing comes' "$(wc -c <away/left.y4m)" "$before"
wait $holder
finish away 10
least 'away: came back' "$(counts left reconnects away.json)" 1
# Ten frames of 320x180 px.
least 'away: the recording goes on' $(($(wc -c <away/left.y4m) - before)) 576000
holds 'away: it says so' 'waiting for a camera' away.err
holds 'away: and when it is back' ': back' away.err

# The page: what cameras are set to while they run, and the eye that is left while the other is away.
ifconfig lo 127.0.0.1 up
# ask METHOD PATH TOKEN: the whole answer. The connection stays open until it is there.
ask() {
    { printf '%s %s HTTP/1.1\r\nHost: 127.0.0.1:8088\r\nX-Tectum-Token: %s\r\n' "$1" "$2" "$3"
      printf 'Content-Length: 0\r\nConnection: close\r\n\r\n'
      sleep 2; } | nc 127.0.0.1 8088
}
v4l2-ctl -d "$A" -c gain_automatic=0,gain=66 >/dev/null
v4l2-ctl -d "$B" -c gain_automatic=0,gain=20 >/dev/null
tectum view --left "$L" --right "$R" --address 127.0.0.1:8088 --frame-size 320x180 \
    --pixel-format GREY --rate 25 --seconds 24 --json >page.json 2>page.err &
viewer=$!
sleep 3
ask POST /lock '' >bare.txt
holds 'page: nothing is set without the token' '403 Forbidden' bare.txt
equal 'page: and stays as it was' "$(v4l2-ctl -d "$B" -C gain)" 'gain: 20'
# These cameras have no exposure time: the page must say something, and go on.
ask POST '/exposure?value=100' "$(sed -n 's/.*#token=//p' page.err)" >exposure.txt
holds 'page: a time of exposure is answered' 'HTTP/1' exposure.txt
ask POST /lock "$(sed -n 's/.*#token=//p' page.err)" >locked.txt
holds 'page: with it the cameras are locked' '200 OK' locked.txt
equal 'page: to the same gain' "$(v4l2-ctl -d "$B" -C gain)" 'gain: 66'
sleep 9 <"$OUT_A" &
holder=$!
fault inject_vidioc_streamon_error=1
fault inject_vidioc_reqbufs_error=1
fault disconnect=1
sleep 5
ask GET /status.json '' >status.txt
holds 'page: says which eye is away' '"left":{"connected":false' status.txt
holds 'page: which the other is not' '"right":{"connected":true' status.txt
holds 'page: what it shows is live' '"stalled":false' status.txt
wait $holder
if wait $viewer; then ok 'page: ends well'; else
    cp page.err /tmp/err
    fail 'page: ends well' "exit code $?"
fi
least 'page: the left eye came back' "$(counts left reconnects page.json)" 1
# Of nine seconds at 25 Hz, less two until the loss is noticed.
alone=$(sed -n 's/.*"alone":\[[0-9]*,\([0-9]*\)\].*/\1/p' page.json)
least 'page: the right eye alone' "$alone" 100

# The clock stands sixteen seconds before it wraps round.
for camera in "$A" "$B"; do v4l2-ctl -d "$camera" -c wrap_timestamp=1 >/dev/null; done
stream wrap 20
finish wrap 100
for camera in "$A" "$B"; do v4l2-ctl -d "$camera" -c wrap_timestamp=0 >/dev/null; done
fault wrap_sequence_number=1
stream sequence 5
finish sequence 10
fault wrap_sequence_number=0

# Many pairs: what is resident must not grow.
tectum stitch /eyes-small.tct --live --left "$L" --right "$R" --pixel-format GREY --rate 60 \
    -o many.y4m --frames 1000 --json >many.json 2>many.err &
many=$!
sleep 5
before=$(sed -n 's/VmRSS:[^0-9]*\([0-9]*\).*/\1/p' /proc/$many/status)
after=$before
while [ -d /proc/$many ] && [ "$(sed -n 's/State:[^A-Z]*\(.\).*/\1/p' /proc/$many/status)" != Z ]; do
    now=$(sed -n 's/VmRSS:[^0-9]*\([0-9]*\).*/\1/p' /proc/$many/status 2>/dev/null)
    after=${now:-$after}
    sleep 1
done
wait $many || { cp many.err /tmp/err; fail 'a thousand pairs' "exit code $?"; }
least 'a thousand pairs' "$(field frames many.json)" 1000
if [ "$after" -le $((before + 1024)) ]; then ok "memory is flat ($before, $after kB)"; else
    fail 'memory is flat' "$before kB became $after kB"
fi

# Real frames through the drivers' own loop, byte for byte.
loop() {
    v4l2-ctl -d "$2" --set-output=1 >/dev/null
    v4l2-ctl -d "$2" --set-dv-bt-timings index=0 >/dev/null
    v4l2-ctl -d "$2" --set-fmt-video-out=width=640,height=480,pixelformat=YUYV >/dev/null
    v4l2-ctl -d "$1" --set-input=3 -c loop_video=1,osd_text_mode=2 >/dev/null
    v4l2-ctl -d "$2" --stream-out-mmap --stream-from="$3" --stream-loop >/dev/null 2>&1 &
    v4l2-ctl -d "$1" --set-dv-bt-timings index=0 >/dev/null
}
loop "$A" "$OUT_A" /left.yuyv
loop "$B" "$OUT_B" /right.yuyv
sleep 2
run 'stitching from cameras' tectum stitch /eyes.tct --live --left "$L" --right "$R" \
    --pixel-format YUYV -o live.y4m --frames 8
run 'stitching from files' tectum stitch /eyes.tct --live --left /left.y4m --right /right.y4m \
    -o files.y4m
# Without the headers, whose frame rates differ; the first frames may come before the loop runs.
frame_bytes=$((640 * 320 * 2))
tail -c $frame_bytes live.y4m >live.raw
tail -c $frame_bytes files.y4m >files.raw
if cmp -s live.raw files.raw && [ "$(wc -c <live.raw)" = $frame_bytes ]; then
    ok 'cameras and files give the same bytes'
else
    fail 'cameras and files give the same bytes' "$(cmp live.raw files.raw 2>&1)"
fi
echo done
poweroff -f
