// Words of measuring without a box: with the phone itself, or with sensors that the browser connects.
export const sensors = {
  'sensors.title': 'No box at hand?',
  'sensors.again': 'Did this device measure?',
  'sensors.phone': 'This phone',
  'sensors.phoneText': 'In a strap around your upper arm.',
  'sensors.bluetooth': 'Bluetooth sensors',
  'sensors.bluetoothText': 'Sensors that this device connects to by itself, without a box.',
  'sensors.box': 'A new box',
  'sensors.boxText': 'Connect a box that you have not used before.',
  'sensors.boxSteps':
    'Switch on the box. Then press the button: you get a code that the box scans, or that you type on it. From then on it joins your exercises by itself.',
  'sensors.boxHelp': 'Let the box scan the picture, or type the code on it. It works once, until {time}.',
  'sensors.boxLabel': 'Box at home',
  'sensors.boxGo': 'Show the code',
  'sensors.back': 'Measure with something else',
  'sensors.phoneStrap':
    'Put the phone into its strap on the outside of your {place}, halfway between shoulder and elbow.',
  'sensors.phoneTight': 'Pull the strap tight: the phone must not slip when you move.',
  'sensors.phoneStart': 'Press the button before you close the strap, and leave this page open.',
  'sensors.phoneSees': 'The phone sees how far you lift your arm, how often, and how evenly.',
  'sensors.phoneSeesNot': 'It does not see your elbow, your hand, where you reach, or whether you lean.',
  'sensors.phoneGo': 'Measure with this phone',
  'sensors.dotSteps': 'Press a place, then choose the sensor that you wear there. Its number is printed on it.',
  'sensors.dotChoose': 'Connect: {place}',
  'sensors.dotAgain': 'Another one',
  'sensors.dotAgainFor': 'Another sensor for: {place}',
  'sensors.dotMissing': { one: 'One sensor is not connected yet.', other: '{count} sensors are not connected yet.' },
  'sensors.status.connecting': 'is being connected',
  'sensors.status.measuring': 'measures',
  'sensors.status.lost': 'lost, is being looked for',
  'sensors.status.failed': 'cannot be used',
  'sensors.battery': 'battery {percent} %',
  'sensors.link.connecting': 'Connecting to your clinic',
  'sensors.link.open': 'Measuring. Everything is sent to your clinic.',
  'sensors.link.behind': 'Measuring. {seconds} are stored on this device and are being sent.',
  'sensors.link.lost':
    'No connection. Your movement is stored on this device and will be sent later. Go on with your exercise.',
  'sensors.link.blocked':
    'This network does not let the connection to your clinic through. Your movement is stored on this device and will be sent later. Use another network, such as mobile data, or ask whoever runs this one.',
  'sensors.link.refused': 'Your clinic does not take the movement.',
  'sensors.link.ended': 'The exercise has ended. Nothing is measured any more.',
  'sensors.stored': 'On this device, not yet sent: {seconds}',
  'sensors.allSent': 'What was measured is stored by your clinic. Nothing waits on this device.',
  'sensors.seconds': { one: 'one second', other: '{count} seconds' },
  'sensors.full':
    'This device has no room left. What cannot be sent at once is lost: free some space, or end the exercise.',
  'sensors.lost': { one: 'A tenth of a second was lost.', other: '{count} tenths of a second were lost.' },
  'sensors.broken':
    'This browser does not store anything, so nothing is measured. Leave private browsing, then try again.',
  'sensors.silent': 'The phone does not measure at the moment. Keep this page in front and the screen on.',
  'sensors.asleep':
    'The screen may go dark here, and then nothing is measured. Switch off automatic locking while you exercise.',
  'sensors.unsent': 'Not sent yet',
  'sensors.unsentSending': 'Being sent to your clinic: {seconds} of movement from an earlier exercise.',
  'sensors.unsentWaiting':
    'Still on this device: {seconds} of movement from an earlier exercise. It is sent as soon as there is a connection.',
  'sensors.unsentRefused':
    'Still on this device: {seconds} of movement from an earlier exercise. It cannot be sent at the moment. Open this page again later.',
  'sensors.unsentSent': 'What was stored on this device has been sent to your clinic. Nothing is missing.',
  'sensors.takenOver': 'Another device is measuring for this exercise now.',
  'sensors.elsewhere': 'You are measuring in another window',
  'sensors.elsewhereText': 'Go on in that window. If you close it, you can go on here.',
  'sensors.unsentOver':
    'Still on this device: {seconds} of movement from an earlier exercise. Your clinic does not take it any more. It is deleted after four weeks, or when you delete it here.',
  'sensors.unsentUnreadable':
    'Still on this device: movement from an earlier exercise, locked with a key that the service no longer has. It cannot be sent any more. Tell your clinic, and do the exercise again.',
  'sensors.unsentDelete': 'Delete from this device',
  'sensors.unsentDeleteTitle': 'Delete what was not sent?',
  'sensors.unsentDeleteText': 'This part of your movement is then gone. The rest, which your clinic has, stays.',
  'sensors.fault.unsupported':
    'This browser cannot connect sensors or does not let pages measure. On Android use Chrome; on an iPhone or iPad measure with the phone itself.',
  'sensors.fault.insecure': 'Measuring needs a secure address. Open the address that begins with https.',
  'sensors.fault.denied': 'The phone was not allowed to measure. Close this page, open it again, and answer “Allow”.',
  'sensors.fault.silent': 'This device has no motion sensors, or the browser does not give them to this page.',
  'sensors.fault.noGyroscope':
    'This phone has no gyroscope, so it cannot follow a movement. Use another phone or the sensors of your clinic.',
  'sensors.fault.noAccelerometer':
    'This phone does not say which way is down. Use another phone or the sensors of your clinic.',
  'sensors.fault.tooSlow':
    'This phone measures too seldom to follow a movement. Switch off battery saving, then try again.',
  'sensors.fault.notChosen': 'No sensor was chosen. Is it charged and switched on? Try again.',
  'sensors.fault.notOurs': 'That is no sensor that we can read. Choose another one.',
  'sensors.fault.radioOff': 'Bluetooth is off or not allowed. Switch it on, allow it for this page, then try again.',
  'sensors.fault.cut':
    'This device takes only a part of what the sensor sends, so it cannot be used. Try another phone, or use the box from your clinic.',
  'sensors.fault.otherWindow':
    'Another window or tab is measuring already. Go on there, or close it and try again here.',
  'sensors.fault.failed': 'That did not work. Switch the sensor off and on, then try again.',
} as const;
